"""Systems that are not linear: those of the families, with laws that bend over the range that the run uses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from benchmarks.galleries.families import (
    FAR,
    NEAR,
    Chance,
    Draw,
    chain,
    driveline,
    geared_rotors,
    hydraulic,
    hydrostatic,
    motor,
    quarter_car,
)
from benchmarks.galleries.judge import Lines, respond
from benchmarks.galleries.network import GROUND, Element, Field, Kind, Law, Network

MOST_BENT = 3  # laws of one system

BENT_FAMILIES: Mapping[str, tuple[Draw, ...]] = {
    "translational chain": tuple(lambda c, n=n: chain(c, n) for n in (2, 2, 3)),
    "quarter car": tuple(lambda c, s=s: quarter_car(c, s, with_weight=False) for s in (False, False, True)),
    "driveline": tuple(lambda c, n=n: driveline(c, n, with_load=False) for n in (6, 7)),
    "geared rotors": (lambda c: geared_rotors(c, 2),),
    "hydraulic circuit": tuple(lambda c, n=n: hydraulic(c, n, with_supply=False) for n in (6, 8)),
    "hydrostatic drive": (lambda c: hydrostatic(c, 7, with_load=False),),
    "quarter car with weight": tuple(lambda c, s=s: quarter_car(c, s, with_weight=True) for s in (False, False, True)),
    "driveline on a slope": tuple(lambda c, n=n: driveline(c, n, with_load=True) for n in (6, 7)),
    "hydraulic circuit under pressure": tuple(lambda c, n=n: hydraulic(c, n, with_supply=True) for n in (6, 8)),
    "motor with a load": tuple(lambda c, n=n: motor(c, n, with_load=True) for n in (6, 7)),
    "hydrostatic drive with a load": (lambda c: hydrostatic(c, 7, with_load=True),),
}

_OFFERED: Mapping[tuple[Field, Kind], tuple[Law, ...]] = {
    (Field.TRANSLATION, Kind.COMPLIANCE): (Law.HARDENING,),
    (Field.TRANSLATION, Kind.RESISTANCE): (Law.SATURATING, Law.FRICTION, Law.QUADRATIC),
    (Field.ROTATION, Kind.RESISTANCE): (Law.FRICTION, Law.QUADRATIC),
    (Field.HYDRAULIC, Kind.RESISTANCE): (Law.QUADRATIC,),
}


def draw_bent_gallery(count: int, seed: int = 1) -> list[Network]:
    """The first networks of a gallery, families in turn."""
    found: list[Network] = []
    turn = 0
    while len(found) < count:
        for number, (family, draws) in enumerate(BENT_FAMILIES.items()):
            spread = NEAR if (turn + number) % 2 == 0 else FAR
            chance = Chance(np.random.default_rng([seed, 1000 + number, turn]), spread)
            drawn = replace(draws[turn % len(draws)](chance), name=f"bent_{family.replace(' ', '_')}_{turn + 1}")
            found.append(replace(bend(drawn, chance), family=family))
        turn += 1
    return found[:count]


def bend(network: Network, chance: Chance) -> Network:
    """Give some elements laws that differ by a factor of two and more over what they do in the linear network."""
    count = len(network.elements)
    response = respond(network)
    seen = Lines(network.stop).instants(response.moved) + response.equilibrium[:, np.newaxis]
    able = [n for n, element in enumerate(network) if _laws(element)]
    chosen = chance.random.choice(able, min(MOST_BENT, len(able)), replace=False)
    elements = list(network.elements)
    for number in chosen:
        element = elements[number]
        driver = seen[number] / element.value if element.kind is Kind.COMPLIANCE else seen[count + number]
        size = float(np.max(np.abs(driver)))
        law = Law(chance.among(*_laws(element)))
        scale = size * float(chance.random.uniform(0.3, 0.9))
        if law in (Law.SATURATING, Law.FRICTION):
            # What has to be carried at rest is at most half of what such a law can give: otherwise there is no rest.
            scale = max(scale, 2.0 * abs(response.equilibrium[number]) / element.value)
        elements[number] = replace(element, law=law, scale=scale)
    return replace(network, elements=tuple(elements))


def _laws(element: Element) -> tuple[Law, ...]:
    """The laws that the library has for an element; drag, and dry friction of shafts, act against the ground."""
    offered = _OFFERED.get((element.place.field, element.kind), ())
    is_grounded = element.place.b == GROUND and element.place.a != GROUND
    against_ground = {Law.QUADRATIC} if element.place.field is Field.TRANSLATION else {Law.QUADRATIC, Law.FRICTION}
    if element.place.field is Field.HYDRAULIC:
        return offered
    return tuple(law for law in offered if is_grounded or law not in against_ground)
