"""Drawn bond graphs: a picture document of a model, and its drawing as SVG."""
