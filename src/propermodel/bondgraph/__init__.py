"""The bondgraph room."""
