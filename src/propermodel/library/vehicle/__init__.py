"""Road vehicles on the pitch plane: tyres, axles, body, road, driver, power management, and whole trucks.

Sign convention: x forward, z up, pitch nose up, wheels positive when rolling forward. Vertical displacements and forces
count from static equilibrium; in `world_frame` springs carry the weight, and hills come through the tyres.
"""
