"""The equations room."""
