"""Measurements: speed, memory and growth, printed with what made them."""
