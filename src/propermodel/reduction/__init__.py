"""The reduction room."""
