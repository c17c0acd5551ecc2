"""Mechanics: translation along a line, rotation about an axis, and bodies that move in a plane."""
