"""A chain of masses, springs and dampers of any length."""

from __future__ import annotations

from propermodel.library.mechanics.translation import Mass, SpringDamper
from propermodel.modelling import Component, Port, Translation, chain, connect, prescribed_flow, repeat


class Section(Component):
    """A spring and a damper that lead to a mass."""

    a = Port(Translation)
    b = Port(Translation)
    link = SpringDamper(stiffness=1.0e3, damping=1.0)
    mass = Mass(mass=1.0)
    connections = (connect(a, link.a), connect(b, link.b, mass.flange))


def chain_model(size: int) -> Component:
    """A chain of `size` sections, moved at its left end."""

    class Chain(Component):
        left = Port(Translation)
        sections = repeat(size, Section())
        last = Mass(mass=1.0)
        connections = (
            connect(left, sections[0].a),
            *chain(sections, "b", "a"),
            connect(sections[size - 1].b, last.flange),
            prescribed_flow(left),
        )

    return Chain()
