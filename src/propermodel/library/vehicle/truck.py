"""6x6 medium tactical trucks (FMTV family): with a parallel hydraulic hybrid, and conventional.

After Louca and Yildir, Mathematical and Computer Modelling of Dynamical Systems 12 (2006) 203-218. Every phenomenon is
in first, whether or not it matters: the hybrid truck has 57 energy elements. What controllers know about the truck are
the parameters of its parts.
"""

from __future__ import annotations

from propermodel.library.mechanics.rotation import RotationalSpringDamper
from propermodel.library.powertrain.converter import ChargingPump, TorqueConverter
from propermodel.library.powertrain.driveline import Driveline
from propermodel.library.powertrain.engine import Engine
from propermodel.library.powertrain.hydraulic_hybrid import HydraulicHybrid
from propermodel.library.powertrain.transmission import Transmission
from propermodel.library.powertrain.transmission_control import TransmissionControl
from propermodel.library.vehicle.chassis import Chassis
from propermodel.library.vehicle.driver import Driver
from propermodel.library.vehicle.power_management import EngineManagement, HybridManagement
from propermodel.modelling import Component, Parameter, connect, parameter

TUBE = "G J / L of a steel tube 90/80 mm, 0.6 m"


class HybridTruck(Component):
    """A loaded M1083 with a hydraulic pump/motor at its transfer case."""

    sprung_mass: Parameter = parameter("kg", default=11300.0, low=0.0, source="14 500 kg less axles", status="derived")
    shaft_stiffness: Parameter = parameter("N.m/rad", default=3.2e5, low=0.0, source=TUBE, status="estimated")
    shaft_damping: Parameter = parameter("N.m.s/rad", default=60.0, low=0.0, status="estimated")

    engine = Engine()
    charging_pump = ChargingPump()
    converter = TorqueConverter()
    transmission = Transmission()
    output_shaft = RotationalSpringDamper(stiffness=shaft_stiffness, damping=shaft_damping)
    driveline = Driveline()
    chassis = Chassis(sprung_mass=sprung_mass)
    hydraulics = HydraulicHybrid()
    driver = Driver(
        mass=chassis.sprung_mass + chassis.front_axle_mass + 2.0 * chassis.rear_axle_mass,
        wheel_radius=chassis.wheel_radius,
        final_drive_ratio=chassis.final_drive_ratio,
        drag_area=chassis.drag_area,
        air_density=chassis.air_density,
        gravity=chassis.gravity,
    )
    power_management = HybridManagement(
        brake_torque=chassis.brake_torque,
        final_drive_ratio=chassis.final_drive_ratio,
        churning_damping=transmission.churning_damping,
        charging_torque=charging_pump.torque,
        accessory_power=engine.accessory_power,
        accessory_speed=engine.accessories.lowest_speed,
        displacement=hydraulics.displacement,
        gear_ratio=hydraulics.gear_ratio,
        unit_efficiency=hydraulics.gear_efficiency,
        viscous=hydraulics.pump_motor.torque_loss.viscous * hydraulics.pump_motor.torque_loss.viscosity,
        coulomb=hydraulics.pump_motor.torque_loss.coulomb,
        hydrodynamic=hydraulics.pump_motor.torque_loss.hydrodynamic * hydraulics.pump_motor.torque_loss.density,
        isolation_width=hydraulics.pump_motor.torque_loss.isolation_width,
        speed_width=hydraulics.pump_motor.torque_loss.width,
    )
    transmission_control = TransmissionControl(shift_time=transmission.shift.shift_time)

    connections = (
        # Power: engine to wheels, with the pump/motor at the transfer case.
        connect(engine.crankshaft, charging_pump.shaft, converter.impeller),
        connect(converter.turbine, transmission.turbine),
        connect(transmission.output, output_shaft.a),
        connect(output_shaft.b, hydraulics.drive, driveline.drive),
        connect(driveline.front, chassis.front_shaft),
        connect(driveline.rear_front, chassis.rear_front_shaft),
        connect(driveline.rear_rear, chassis.rear_rear_shaft),
        # The driver sees speed and road, and how hard the engine works.
        connect(chassis.speed, driver.speed, power_management.speed),
        connect(chassis.sine_slope, driver.sine_slope),
        connect(chassis.rolling_coefficient, driver.rolling_coefficient),
        connect(power_management.engine_demand, driver.engine_demand, engine.demand),
        connect(engine.full_load_torque, driver.full_load_torque, power_management.full_load_torque),
        # Power management shares the wish between engine, unit and brakes.
        connect(driver.wish, power_management.wish),
        connect(driver.standstill, power_management.standstill, transmission_control.standstill),
        connect(engine.crankshaft.flow, power_management.engine_speed, transmission_control.engine_speed),
        connect(converter.torque_ratio, power_management.torque_ratio),
        connect(transmission.ratio, power_management.ratio),
        connect(transmission.efficiency, power_management.gear_efficiency),
        connect(transmission.output.flow, power_management.output_speed),
        connect(power_management.brake_pedal, chassis.brake_pedal),
        connect(power_management.stroke_command, hydraulics.stroke_command),
        connect(hydraulics.stroke, power_management.stroke),
        connect(hydraulics.accumulator_pressure, power_management.accumulator_pressure),
        connect(hydraulics.reservoir_pressure, power_management.reservoir_pressure),
        connect(hydraulics.accumulator_oil, power_management.accumulator_oil),
        # Shift, lock-up, neutral.
        connect(power_management.throttle, transmission_control.throttle),
        connect(transmission.turbine.flow, transmission_control.turbine_speed),
        connect(transmission_control.from_gear, transmission.from_gear),
        connect(transmission_control.to_gear, transmission.to_gear),
        connect(transmission_control.shift_start, transmission.shift_start),
        connect(transmission_control.engagement, converter.engagement),
        connect(transmission_control.clutch_capacity, converter.clutch_capacity),
        connect(transmission_control.clutch_closed, converter.clutch_closed, power_management.clutch_closed),
    )


class ConventionalTruck(Component):
    """The same truck without hydraulics, 600 kg lighter."""

    sprung_mass: Parameter = parameter("kg", default=10700.0, low=0.0, source="13 900 kg less axles", status="derived")
    shaft_stiffness: Parameter = parameter("N.m/rad", default=3.2e5, low=0.0, source=TUBE, status="estimated")
    shaft_damping: Parameter = parameter("N.m.s/rad", default=60.0, low=0.0, status="estimated")

    engine = Engine()
    charging_pump = ChargingPump()
    converter = TorqueConverter()
    transmission = Transmission()
    output_shaft = RotationalSpringDamper(stiffness=shaft_stiffness, damping=shaft_damping)
    driveline = Driveline()
    chassis = Chassis(sprung_mass=sprung_mass)
    driver = Driver(
        mass=chassis.sprung_mass + chassis.front_axle_mass + 2.0 * chassis.rear_axle_mass,
        wheel_radius=chassis.wheel_radius,
        final_drive_ratio=chassis.final_drive_ratio,
        drag_area=chassis.drag_area,
        air_density=chassis.air_density,
        gravity=chassis.gravity,
    )
    power_management = EngineManagement(
        brake_torque=chassis.brake_torque,
        final_drive_ratio=chassis.final_drive_ratio,
        churning_damping=transmission.churning_damping,
        charging_torque=charging_pump.torque,
        accessory_power=engine.accessory_power,
        accessory_speed=engine.accessories.lowest_speed,
    )
    transmission_control = TransmissionControl(shift_time=transmission.shift.shift_time)

    connections = (
        # Power: engine to wheels.
        connect(engine.crankshaft, charging_pump.shaft, converter.impeller),
        connect(converter.turbine, transmission.turbine),
        connect(transmission.output, output_shaft.a),
        connect(output_shaft.b, driveline.drive),
        connect(driveline.front, chassis.front_shaft),
        connect(driveline.rear_front, chassis.rear_front_shaft),
        connect(driveline.rear_rear, chassis.rear_rear_shaft),
        # The driver sees speed and road, and how hard the engine works.
        connect(chassis.speed, driver.speed),
        connect(chassis.sine_slope, driver.sine_slope),
        connect(chassis.rolling_coefficient, driver.rolling_coefficient),
        connect(power_management.engine_demand, driver.engine_demand, engine.demand),
        connect(engine.full_load_torque, driver.full_load_torque, power_management.full_load_torque),
        # Power management shares the wish between engine and brakes.
        connect(driver.wish, power_management.wish),
        connect(driver.standstill, power_management.standstill, transmission_control.standstill),
        connect(engine.crankshaft.flow, power_management.engine_speed, transmission_control.engine_speed),
        connect(converter.torque_ratio, power_management.torque_ratio),
        connect(transmission.ratio, power_management.ratio),
        connect(transmission.efficiency, power_management.gear_efficiency),
        connect(transmission.output.flow, power_management.output_speed),
        connect(power_management.brake_pedal, chassis.brake_pedal),
        # Shift, lock-up, neutral.
        connect(power_management.throttle, transmission_control.throttle),
        connect(transmission.turbine.flow, transmission_control.turbine_speed),
        connect(transmission_control.from_gear, transmission.from_gear),
        connect(transmission_control.to_gear, transmission.to_gear),
        connect(transmission_control.shift_start, transmission.shift_start),
        connect(transmission_control.engagement, converter.engagement),
        connect(transmission_control.clutch_capacity, converter.clutch_capacity),
        connect(transmission_control.clutch_closed, converter.clutch_closed, power_management.clutch_closed),
    )
