"""Families of linear systems with parameters drawn by chance: half near their usual values, half far from them.

Usual values are invented. Everything follows from the seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.galleries.network import (
    GROUND,
    INTERVALS,
    Coupling,
    Drive,
    Element,
    Field,
    FloatArray,
    Half,
    Kind,
    Network,
    Output,
    Place,
)

T, O, E, H = Field.TRANSLATION, Field.ROTATION, Field.ELECTRICAL, Field.HYDRAULIC
R, C, I = Kind.RESISTANCE, Kind.COMPLIANCE, Kind.INERTIA
NEAR, FAR = 2.0, 16.0  # factors up and down between which a parameter lies


@dataclass(frozen=True)
class Chance:
    """Draws what differs between the systems of a family."""

    random: np.random.Generator
    spread: float

    def about(self, usual: float) -> float:
        """A value not too far from the usual one."""
        return float(usual * self.spread ** self.random.uniform(-1.0, 1.0))

    def among(self, *choices: str) -> str:
        """One of some words."""
        return str(self.random.choice(choices))

    def whole(self, low: int, high: int) -> int:
        """A whole number, both ends included."""
        return int(self.random.integers(low, high + 1))

    def signal(self, amplitude: float, shape: str = "") -> FloatArray:
        """A smooth signal over the window that begins at zero."""
        t = np.linspace(0.0, 1.0, INTERVALS + 1)
        begin, length = self.random.uniform(0.02, 0.1), self.random.uniform(0.04, 0.3)
        match shape or self.among("step", "pulse", "sine", "two sines", "noise"):
            case "step":
                return amplitude * _rise((t - begin) / length)
            case "pulse":
                return amplitude * (_rise((t - begin) / length) - _rise((t - begin - length) / length))
            case "sine":
                return amplitude * _rise(t / 0.2) * np.sin(2.0 * math.pi * self.random.uniform(2.0, 12.0) * t)
            case "two sines":
                slow, fast = self.random.uniform(1.0, 3.0), self.random.uniform(6.0, 20.0)
                both = np.sin(2.0 * math.pi * slow * t) + 0.4 * np.sin(2.0 * math.pi * fast * t)
                return amplitude * _rise(t / 0.1) * both
            case _:
                lines = np.arange(1, 16)
                sizes = self.random.normal(size=(2, len(lines))) / np.sqrt(lines)
                angles = 2.0 * math.pi * np.outer(lines, t)
                return 0.5 * amplitude * _rise(t / 0.1) * (sizes[0] @ np.sin(angles) + sizes[1] @ np.cos(angles))


def _rise(x: FloatArray) -> FloatArray:
    """From 0 to 1 while x does, with three continuous derivatives."""
    y = np.clip(x, 0.0, 1.0)
    return y**4 * (35.0 - 84.0 * y + 70.0 * y**2 - 20.0 * y**3)


# -- mechanics -----------------------------------------------------------------------------------------------


def chain(chance: Chance, stages: int, field: Field = T) -> Network:
    """A tree of bodies on springs and dampers; force or motion at one end."""
    elements: list[Element] = []
    nodes = [GROUND if chance.among("pushed", "moved") == "pushed" else "base"]
    for number in range(1, stages + 1):
        is_branch = chance.among("chain", "chain", "tree") == "tree"
        # Only the first body stands at the ground: what has a branch of its own there would not feel the push.
        before = nodes[chance.whole(min(1, len(nodes) - 1), len(nodes) - 1)] if is_branch else nodes[-1]
        here, place = f"n{number}", Place(field, f"n{number}")
        elements += [
            Element(f"spring_{number}", C, Place(field, before, here), chance.about(400.0)),
            Element(f"damper_{number}", R, Place(field, before, here), chance.about(4.0)),
            Element(f"body_{number}", I, place, chance.about(1.0)),
        ]
        nodes.append(here)
    drive = (
        Drive("push", nodes[-1], Half.EFFORT, chance.signal(10.0))
        if nodes[0] == GROUND
        else Drive("motion", "base", Half.FLOW, chance.signal(0.2))
    )
    last = chance.whole(1, stages)
    outputs = [Output(f"body_{last}", Half.FLOW)]
    if chance.among("one", "two") == "two":
        outputs.append(Output(f"body_{stages}" if last != stages else "body_1", Half.FLOW))
    return Network(name="", family="", elements=tuple(elements), drives=(drive,), outputs=_different(outputs), stop=3.0)


def quarter_car(chance: Chance, with_seat: bool, with_weight: bool) -> Network:
    """Body, wheel, suspension and tyre on a road, perhaps a seat; with weight the springs are loaded."""
    between = {"tyre": ("road", "wheel", 2.4e5, 300.0), "suspension": ("wheel", "body", 2.5e4, 1800.0)}
    bodies = {"wheel": 60.0, "body": 500.0}
    if with_seat:
        between["seat"], bodies["driver"] = ("body", "driver", 2.0e4, 500.0), 70.0
    elements: list[Element] = []
    for name, (a, b, stiffness, damping) in between.items():
        elements.append(Element(f"{name}_spring", C, Place(T, a, b), chance.about(stiffness)))
        elements.append(Element(f"{name}_damper", R, Place(T, a, b), chance.about(damping)))
    elements += [Element(name, I, Place(T, name), chance.about(mass)) for name, mass in bodies.items()]
    drives = [Drive("road_motion", "road", Half.FLOW, chance.signal(0.3))]
    if with_weight:
        masses = {element.name: element.value for element in elements if element.kind is I}
        drives += [Drive(f"{name}_weight", name, Half.EFFORT, -9.81 * mass) for name, mass in masses.items()]
    outputs = [Output("driver" if with_seat else "body", Half.FLOW)]
    if chance.among("one", "two") == "two":
        outputs.append(Output("suspension_spring", Half.EFFORT))
    return Network(name="", family="", elements=tuple(elements), drives=tuple(drives), outputs=tuple(outputs), stop=4.0)


def half_car(chance: Chance, with_tyre_damping: bool, with_weight: bool) -> Network:
    """A body that heaves and pitches on two axles; the rear axle meets the road later."""
    elements = [
        Element("body", I, Place(T, "body"), chance.about(900.0)),
        Element("pitch", I, Place(O, "pitch"), chance.about(1200.0)),
    ]
    couplings: list[Coupling] = []
    signal = chance.signal(0.3)
    drives: list[Drive] = []
    for name, arm, delay in (("front", -1.3, 0), ("rear", 1.4, INTERVALS // 16)):
        corner, wheel, road = f"{name}_corner", f"{name}_wheel", f"{name}_road"
        couplings.append(Coupling(f"{name}_arm", Place(O, "pitch"), Place(T, corner, "body"), arm))
        elements += [
            Element(f"{name}_spring", C, Place(T, wheel, corner), chance.about(2.2e4)),
            Element(f"{name}_damper", R, Place(T, wheel, corner), chance.about(1500.0)),
            Element(wheel, I, Place(T, wheel), chance.about(50.0)),
            Element(f"{name}_tyre", C, Place(T, road, wheel), chance.about(2.2e5)),
        ]
        if with_tyre_damping:
            elements.append(Element(f"{name}_tyre_damper", R, Place(T, road, wheel), chance.about(200.0)))
        late = np.concatenate([np.zeros(delay), signal[: len(signal) - delay]])
        drives.append(Drive(f"{name}_motion", road, Half.FLOW, late))
    if with_weight:
        drives.append(Drive("weight", "body", Half.EFFORT, -9.81 * elements[0].value))
    outputs = (Output("body", Half.FLOW), Output("pitch", Half.FLOW))[: chance.whole(1, 2)]
    return Network(
        name="",
        family="",
        elements=tuple(elements),
        couplings=tuple(couplings),
        drives=tuple(drives),
        outputs=outputs,
        stop=4.0,
    )


def driveline(chance: Chance, size: int, with_load: bool) -> Network:
    """An engine drives a vehicle through a clutch, a gear, a shaft and a tyre; with a load it climbs steadily."""
    elements = [
        Element("engine", I, Place(O, "crank"), chance.about(1.0)),
        Element("clutch_spring", C, Place(O, "crank", "input"), chance.about(2000.0)),
        Element("clutch_damper", R, Place(O, "crank", "input"), chance.about(30.0)),
        Element("vehicle", I, Place(T, "vehicle"), chance.about(1500.0)),
        Element("drag", R, Place(T, "vehicle"), chance.about(100.0)),
        Element("tyre_damper", R, Place(T, "rim", "vehicle"), chance.about(3000.0)),
        Element("gear_inertia", I, Place(O, "input"), chance.about(0.05)),
        Element("shaft", C, Place(O, "output", "hub"), chance.about(8000.0)),
        Element("hub", I, Place(O, "hub"), chance.about(2.0)),
        Element("shaft_damper", R, Place(O, "output", "hub"), chance.about(40.0)),
        Element("tyre_spring", C, Place(T, "rim", "vehicle"), chance.about(2.0e5)),
        Element("crank_friction", R, Place(O, "crank"), chance.about(0.05)),
    ][:size]
    has_shaft = size > 7
    couplings = (
        Coupling("gear", Place(O, "input"), Place(O, "output" if has_shaft else "hub"), 1.0 / 6.0),
        Coupling("wheel", Place(O, "hub"), Place(T, "rim"), 0.3),
    )
    drives = [Drive("torque", "crank", Half.EFFORT, chance.signal(100.0))]
    if with_load:
        steady = 60.0
        drives += [
            Drive("steady_torque", "crank", Half.EFFORT, steady),
            Drive("slope", "vehicle", Half.EFFORT, -steady * 6.0 / 0.3 * 0.9),
        ]
    outputs = [Output("vehicle", Half.FLOW)]
    if chance.among("one", "two") == "two":
        outputs.append(Output("engine", Half.FLOW))
    return Network(
        name="",
        family="",
        elements=tuple(elements),
        couplings=couplings,
        drives=tuple(drives),
        outputs=tuple(outputs),
        stop=4.0,
    )


def geared_rotors(chance: Chance, stages: int) -> Network:
    """Rotors on shafts with a gear between any two of them."""
    elements: list[Element] = []
    couplings: list[Coupling] = []
    node = "in_1"
    for number in range(1, stages + 1):
        out = f"out_{number}"
        elements += [
            Element(f"rotor_{number}", I, Place(O, node), chance.about(0.1)),
            Element(f"shaft_{number}", C, Place(O, node, out), chance.about(300.0)),
            Element(f"loss_{number}", R, Place(O, out), chance.about(0.2)),
        ]
        if number < stages:
            node = f"in_{number + 1}"
            ratio = float(chance.random.uniform(0.4, 2.5))
            couplings.append(Coupling(f"gear_{number}", Place(O, out), Place(O, node), ratio))
        else:
            elements.append(Element("load", I, Place(O, out), chance.about(0.3)))
    return Network(
        name="",
        family="",
        elements=tuple(elements),
        couplings=tuple(couplings),
        drives=(Drive("torque", "in_1", Half.EFFORT, chance.signal(5.0)),),
        outputs=(Output(chance.among("load", "rotor_1"), Half.FLOW),),
        stop=3.0,
    )


# -- electricity, hydraulics ---------------------------------------------------------------------------------


def ladder(chance: Chance, stages: int, with_leaks: bool) -> Network:
    """Sections of a line: resistance and inductance in series, capacitance across."""
    elements: list[Element] = []
    node = "source"
    for number in range(1, stages + 1):
        middle, end = f"m{number}", f"n{number}"
        elements += [
            Element(f"resistor_{number}", R, Place(E, node, middle), chance.about(10.0)),
            Element(f"coil_{number}", I, Place(E, middle, end), chance.about(0.1)),
            Element(f"capacitor_{number}", C, Place(E, end), chance.about(1e4)),
        ]
        if with_leaks:
            elements.append(Element(f"leak_{number}", R, Place(E, end), chance.about(400.0)))
        node = end
    outputs = [Output(f"capacitor_{stages}", Half.EFFORT)]
    if chance.among("one", "two") == "two":
        outputs.append(Output("coil_1", Half.FLOW))
    return Network(
        name="",
        family="",
        elements=tuple(elements),
        drives=(Drive("voltage", "source", Half.EFFORT, chance.signal(10.0)),),
        outputs=tuple(outputs),
        stop=0.15,
    )


def resonance(chance: Chance, stages: int) -> Network:
    """A series branch driven at its resonance, where coil and capacitor cancel, before the rest of a ladder."""
    found = ladder(replace(chance, spread=min(chance.spread, 6.0)), stages, with_leaks=False)
    cycles = float(chance.random.uniform(8.0, 14.0))
    omega = 2.0 * math.pi * cycles / found.stop
    quality = float(chance.random.uniform(0.5, 1.5))
    # The last section's capacitor stands in series: what passes it meets a resistance.
    reactance = quality * 30.0
    elements = (
        Element("tuned_coil", I, Place(E, "source", "p"), reactance / omega),
        Element("tuned_capacitor", C, Place(E, "p", "q"), reactance * omega),
        Element("resistor_0", R, Place(E, "q", "start"), 15.0),
        Element("load", R, Place(E, "start"), chance.about(60.0)),
        *(replace(e, place=Place(E, e.place.a.replace("source", "start"), e.place.b)) for e in found.elements),
    )
    t = np.linspace(0.0, 1.0, INTERVALS + 1)
    signal = 10.0 * _rise(t / 0.6) * np.sin(2.0 * math.pi * cycles * t)
    return replace(
        found,
        elements=elements,
        drives=(Drive("voltage", "source", Half.EFFORT, signal),),
        outputs=(Output("load", Half.EFFORT),),
    )


def absorber(chance: Chance) -> Network:
    """A base moved at the frequency at which the pull of a body and that of its spring cancel."""
    cycles = float(chance.random.uniform(10.0, 16.0))
    stop = 3.0
    omega = 2.0 * math.pi * cycles / stop
    mass = chance.about(0.3)
    t = np.linspace(0.0, 1.0, INTERVALS + 1)
    elements = (
        Element("cradle", I, Place(T, "n1"), mass),
        Element("tether", C, Place(T, "n1"), mass * omega * omega),
        Element("coupler", R, Place(T, "base", "n1"), chance.about(0.8 * mass * omega)),
        Element("drain", R, Place(T, "n1"), chance.about(0.8 * mass * omega)),
        Element("link", C, Place(T, "n1", "n2"), chance.about(400.0)),
        Element("link_damper", R, Place(T, "n1", "n2"), chance.about(4.0)),
        Element("body", I, Place(T, "n2"), chance.about(1.0)),
    )
    return Network(
        name="",
        family="",
        elements=elements,
        drives=(Drive("motion", "base", Half.FLOW, 0.2 * _rise(t / 0.6) * np.sin(2.0 * math.pi * cycles * t)),),
        outputs=(Output(chance.among("drain", "body"), Half.FLOW),),
        stop=stop,
    )


def hydraulic(chance: Chance, size: int, with_supply: bool) -> Network:
    """A pump feeds a line with chambers and a load; with a supply it runs at pressure all the time."""
    elements = [
        Element("chamber_1", C, Place(H, "n1"), chance.about(1e12)),
        Element("leak", R, Place(H, "n1"), chance.about(3e10)),
        Element("pipe", R, Place(H, "n1", "m1"), chance.about(1.5e9)),
        Element("oil", I, Place(H, "m1", "n2"), chance.about(1.5e7)),
        Element("chamber_2", C, Place(H, "n2"), chance.about(1e12)),
        Element("load", R, Place(H, "n2"), chance.about(1e10)),
        Element("accumulator", C, Place(H, "n3"), chance.about(3e10)),
        Element("neck", R, Place(H, "n2", "n3"), chance.about(5e9)),
        Element("return_oil", I, Place(H, "n2", "m4"), chance.about(5e7)),
        Element("return_pipe", R, Place(H, "m4"), chance.about(2e10)),
    ][:size]
    drives = [Drive("pump", "n1", Half.FLOW, chance.signal(2e-4))]
    if with_supply:
        drives.append(Drive("supply", "n1", Half.FLOW, 5e-4))
    outputs = [Output("chamber_2", Half.EFFORT)]
    if chance.among("one", "two") == "two":
        outputs.append(Output("chamber_1", Half.EFFORT))
    return Network(name="", family="", elements=tuple(elements), drives=tuple(drives), outputs=tuple(outputs), stop=0.4)


# -- two domains ---------------------------------------------------------------------------------------------


def motor(chance: Chance, size: int, with_load: bool) -> Network:
    """A motor turns a load through a gear and a shaft; with a load it lifts something all the time."""
    elements = [
        Element("coil", I, Place(E, "supply", "m"), chance.about(5e-3)),
        Element("winding", R, Place(E, "m", "brush"), chance.about(0.5)),
        Element("rotor", I, Place(O, "rotor"), chance.about(2e-3)),
        Element("bearing", R, Place(O, "rotor"), chance.about(2e-3)),
        Element("load", I, Place(O, "load"), chance.about(0.05)),
        Element("load_friction", R, Place(O, "load"), chance.about(0.05)),
        Element("shaft", C, Place(O, "gear", "load"), chance.about(60.0)),
        Element("shaft_damper", R, Place(O, "gear", "load"), chance.about(0.1)),
        Element("gear_inertia", I, Place(O, "gear"), chance.about(5e-3)),
        Element("filter", C, Place(E, "supply"), chance.about(500.0)),
    ][:size]
    if size == 10:
        source, at = "plug", Element("cable", R, Place(E, "plug", "supply"), chance.about(0.1))
        elements.append(at)
    else:
        source = "supply"
    couplings = (
        Coupling("conversion", Place(E, "brush"), Place(O, "rotor"), 0.1, is_gyrator=True),
        Coupling("gearing", Place(O, "rotor"), Place(O, "gear" if size > 6 else "load"), 0.2),
    )
    drives = [Drive("voltage", source, Half.EFFORT, chance.signal(12.0))]
    if with_load:
        drives.append(Drive("lifted", "load", Half.EFFORT, -0.5))
    outputs = [Output("load", Half.FLOW)]
    if chance.among("one", "two") == "two":
        outputs.append(Output("coil", Half.FLOW))
    return Network(
        name="",
        family="",
        elements=tuple(elements),
        couplings=couplings,
        drives=tuple(drives),
        outputs=tuple(outputs),
        stop=1.0,
    )


def loudspeaker(chance: Chance) -> Network:
    """A voice coil moves a cone."""
    elements = (
        Element("coil", I, Place(E, "pin", "m"), chance.about(2e-3)),
        Element("winding", R, Place(E, "m", "coil"), chance.about(6.0)),
        Element("cone", I, Place(T, "cone"), chance.about(0.02)),
        Element("suspension", C, Place(T, "cone"), chance.about(1500.0)),
        Element("loss", R, Place(T, "cone"), chance.about(1.5)),
        Element("dust_cap", I, Place(T, "cap"), chance.about(0.003)),
        Element("glue", C, Place(T, "cone", "cap"), chance.about(2e4)),
        Element("glue_loss", R, Place(T, "cone", "cap"), chance.about(1.0)),
    )
    return Network(
        name="",
        family="",
        elements=elements,
        couplings=(Coupling("motor", Place(E, "coil"), Place(T, "cone"), 8.0, is_gyrator=True),),
        drives=(Drive("voltage", "pin", Half.EFFORT, chance.signal(10.0)),),
        outputs=(Output("cone", Half.FLOW),),
        stop=0.3,
    )


def hydrostatic(chance: Chance, size: int, with_load: bool) -> Network:
    """An engine drives a pump, oil a piston, and the piston a carriage."""
    elements = [
        Element("engine", I, Place(O, "crank"), chance.about(0.5)),
        Element("friction", R, Place(O, "crank"), chance.about(0.5)),
        Element("oil", C, Place(H, "high"), chance.about(2e11)),
        Element("leak", R, Place(H, "high"), chance.about(3e11)),
        Element("pipe", R, Place(H, "high", "cylinder"), chance.about(2e9)),
        Element("carriage", I, Place(T, "carriage"), chance.about(200.0)),
        Element("guide", R, Place(T, "carriage"), chance.about(800.0)),
        Element("cylinder_oil", C, Place(H, "cylinder"), chance.about(1e12)),
        Element("rod", C, Place(T, "piston", "carriage"), chance.about(2e6)),
        Element("piston", I, Place(T, "piston"), chance.about(5.0)),
        Element("rod_damper", R, Place(T, "piston", "carriage"), chance.about(2e3)),
    ][:size]
    has_rod = size > 8
    couplings = (
        Coupling("pump", Place(O, "crank"), Place(H, "high"), 5e-6),
        Coupling("cylinder", Place(T, "piston" if has_rod else "carriage"), Place(H, "cylinder"), -1e-3),
    )
    drives = [Drive("torque", "crank", Half.EFFORT, chance.signal(20.0))]
    if with_load:
        drives += [Drive("idling", "crank", Half.EFFORT, 15.0), Drive("pull", "carriage", Half.EFFORT, -1500.0)]
    outputs = [Output("carriage", Half.FLOW)]
    if chance.among("one", "two") == "two":
        outputs.append(Output("oil", Half.EFFORT))
    return Network(
        name="",
        family="",
        elements=tuple(elements),
        couplings=couplings,
        drives=tuple(drives),
        outputs=tuple(outputs),
        stop=3.0,
    )


def _different(outputs: list[Output]) -> tuple[Output, ...]:
    return tuple(dict.fromkeys(outputs))


# -- the gallery ---------------------------------------------------------------------------------------------

Draw = Callable[[Chance], Network]

FAMILIES: Mapping[str, tuple[Draw, ...]] = {
    "translational chain": tuple(lambda c, n=n: chain(c, n) for n in (2, 3, 3, 4)),
    "rotational chain": tuple(lambda c, n=n: chain(c, n, O) for n in (2, 3)),
    "quarter car": tuple(lambda c, s=s: quarter_car(c, s, with_weight=False) for s in (False, True)),
    "quarter car with weight": tuple(lambda c, s=s: quarter_car(c, s, with_weight=True) for s in (False, True)),
    "half car": (lambda c: half_car(c, with_tyre_damping=False, with_weight=False),),
    "driveline": tuple(lambda c, n=n: driveline(c, n, with_load=False) for n in (7, 10, 12)),
    "driveline on a slope": tuple(lambda c, n=n: driveline(c, n, with_load=True) for n in (7, 9)),
    "geared rotors": tuple(lambda c, n=n: geared_rotors(c, n) for n in (2, 3)),
    "electrical ladder": tuple(lambda c, n=n, k=k: ladder(c, n, k) for n, k in ((2, False), (2, True), (3, False))),
    "resonant branch": tuple(lambda c, n=n: resonance(c, n) for n in (1, 2)),
    "tuned cradle": (absorber,),
    "hydraulic circuit": tuple(lambda c, n=n: hydraulic(c, n, with_supply=False) for n in (6, 8, 10)),
    "hydraulic circuit under pressure": tuple(lambda c, n=n: hydraulic(c, n, with_supply=True) for n in (6, 8)),
    "motor": tuple(lambda c, n=n: motor(c, n, with_load=False) for n in (6, 9, 10)),
    "motor with a load": tuple(lambda c, n=n: motor(c, n, with_load=True) for n in (6, 9)),
    "loudspeaker": (loudspeaker,),
    "hydrostatic drive": tuple(lambda c, n=n: hydrostatic(c, n, with_load=False) for n in (7, 11)),
    "hydrostatic drive with a load": tuple(lambda c, n=n: hydrostatic(c, n, with_load=True) for n in (7, 9)),
}


def draw_gallery(count: int, seed: int = 1) -> list[Network]:
    """The first networks of a gallery, families in turn, near and far parameters in turn."""
    found: list[Network] = []
    turn = 0
    while len(found) < count:
        for number, (family, draws) in enumerate(FAMILIES.items()):
            if len(found) == count:
                break
            spread = NEAR if (turn + number) % 2 == 0 else FAR
            chance = Chance(np.random.default_rng([seed, number, turn]), spread)
            drawn = draws[turn % len(draws)](chance)
            name = f"{family.replace(' ', '_')}_{turn + 1}"
            found.append(replace(drawn, name=name, family=family))
        turn += 1
    return found
