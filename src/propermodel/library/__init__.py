"""Ready-made components, written as a customer would: on modelling and expressions alone.

Every domain has the same shelves: `components`, `sources`, `sensors`, and where it needs them `machines` and
`fluids`. Its `__init__` says in words which way its variables count.
"""
