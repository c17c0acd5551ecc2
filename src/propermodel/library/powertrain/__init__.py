"""Powertrains: combustion engine, torque converter, automatic transmission, transfer cases, and a hydraulic hybrid.

Sign convention: all shafts count positive in the driving sense; power that drives passes from `a` to `b`, from the
engine to the wheels.
"""
