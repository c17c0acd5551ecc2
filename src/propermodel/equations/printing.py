"""Sorted equations as text: shared quantities are named once, after the port or signal they are."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from propermodel.expressions.core import Expr, Op, postorder
from propermodel.expressions.printing import to_text

if TYPE_CHECKING:
    from propermodel.equations.system import EquationSystem


def equations_text(system: EquationSystem) -> str:
    """The equations in the order in which they can be computed."""
    lines = [f"equations of {system.causal.graph.model.name}: {len(system.states)} states"]
    for block in system.solved:
        names = ", ".join(str(path) for path in dict.fromkeys(block.paths))
        lines.append(f"  solved exactly: {names} ({block.kinds[0]})")
    for block in system.blocks:
        names = ", ".join(str(path) for path in dict.fromkeys(block.paths))
        lines.append(f"  solved by Newton's method: {names}")
    roots = [state.derivative for state in system.states]
    roots += [residual for block in system.blocks for residual in system.laws_of(block)]
    nodes = postorder(roots)
    names = _names(system, nodes)
    known: dict[Expr, str] = {}
    for node in nodes:
        if node in names:
            lines.append(f"  {names[node]} = {to_text(node, known)}")
            known[node] = names[node]
    for block in system.blocks:
        lines.extend(f"  0 = {to_text(residual, known)}" for residual in system.laws_of(block))
    width = max((len(str(state.path)) for state in system.states), default=0)
    lines.extend(f"  d/dt {s.path!s:<{width}} = {to_text(s.derivative, known)}" for s in system.states)
    return "\n".join(lines)


def _names(system: EquationSystem, nodes: list[Expr]) -> dict[Expr, str]:
    """Names for everything that is used more than once, or that is a physical quantity of its own."""
    present = set(nodes)
    names: dict[Expr, str] = {}
    for leaf, value in system.values.items():
        if value in present and value.args:
            text = str(leaf.data.path)
            if value not in names or len(text) < len(names[value]):
                names[value] = text
    uses = Counter(arg for node in nodes for arg in node.args)
    number = 0
    for node in nodes:
        if node not in names and node.args and uses[node] > 1 and node.op is not Op.NEGATE and not node.is_condition:
            number += 1
            names[node] = f"v{number}"
    return names
