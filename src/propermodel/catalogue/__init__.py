"""The catalogue: models by name, from files of Python, documents and runs, each with its scenarios."""
