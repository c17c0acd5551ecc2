"""Values of parameters as people write them, with their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from propermodel.bondgraph.flatten import flatten
from propermodel.diagnostics import Diagnostic, Faults, Path, ProperModelError, nearest, parse_path
from propermodel.expressions.units import parse_quantity
from propermodel.modelling import Model


def read_settings(model: Model, given: Mapping[str, str], faults: Faults) -> dict[Path, float]:
    """Values in SI of parameters of a model by path, from texts such as `1500 kg`.

    A name that is no parameter, and a value or unit that does not fit, is added to the faults.
    """
    known = flatten(model).parameters if given else {}
    found: dict[Path, float] = {}
    for name, value in given.items():
        path = parse_path(name)
        if path not in known:
            faults.add(
                Diagnostic(
                    "simulation/unknown-parameter",
                    f"the model has no parameter '{path}'",
                    help=nearest(str(path), (str(p) for p in known))
                    or "propermodel show MODEL --parameters lists them",
                )
            )
            continue
        try:
            found[path] = parse_quantity(value, known[path].unit)
        except ProperModelError as error:
            for diagnostic in error.diagnostics:
                faults.add(replace(diagnostic, where=str(path)))
    return found
