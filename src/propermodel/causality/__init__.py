"""The causality room."""
