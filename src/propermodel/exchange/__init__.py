"""Models for other programs and other readers."""
