"""Other bond graph tools on the chain of `growth.py`, from their source to their equations."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass

LIMIT_S = 120.0
SIZES = (5, 10, 20, 57, 200)

BOND_GRAPH_TOOLS = """
import sys, time
import BondGraphTools as bgt
begin = time.process_time()
chain, source, left = bgt.new(name="chain"), bgt.new("Sf", value=1.0), bgt.new("1")
bgt.add(chain, source, left)
bgt.connect(source, left)
for k in range(int(sys.argv[1])):
    zero, link, one = bgt.new("0"), bgt.new("1"), bgt.new("1")
    spring, damper = bgt.new("C", name=f"spring{k}", value=1e-3), bgt.new("R", name=f"damper{k}", value=1.0)
    mass = bgt.new("I", name=f"mass{k}", value=1.0)
    bgt.add(chain, zero, link, one, spring, damper, mass)
    for tail, head in ((left, zero), (zero, link), (link, spring), (link, damper), (zero, one), (one, mass)):
        bgt.connect(tail, head)
    left = one
relations = chain.constitutive_relations
print(time.process_time() - begin)
"""

BONDGRAPH = """
import sys, time
from bondgraph.core import Bond, BondGraph
from bondgraph.elements import Element_C, Element_I, Element_R, Source_flow
from bondgraph.junctions import JunctionEqualEffort, JunctionEqualFlow
from sympy import Symbol
begin = time.process_time()
graph = BondGraph()
left = JunctionEqualFlow("left")
graph.add(Bond(Source_flow("source", Symbol("v")), left))
for k in range(int(sys.argv[1])):
    zero, link, one = JunctionEqualEffort(f"zero{k}"), JunctionEqualFlow(f"link{k}"), JunctionEqualFlow(f"one{k}")
    spring = Element_C(f"spring{k}", Symbol(f"s{k}"), Symbol(f"x{k}"))
    damper = Element_R(f"damper{k}", Symbol(f"d{k}"))
    mass = Element_I(f"mass{k}", Symbol(f"m{k}"), Symbol(f"p{k}"))
    for tail, head in ((left, zero), (zero, link), (link, spring), (link, damper), (zero, one), (one, mass)):
        graph.add(Bond(tail, head))
    left = one
equations = graph.get_state_equations()
assert len(equations) == 2 * int(sys.argv[1])
print(time.process_time() - begin)
"""


@dataclass(frozen=True)
class PeerTime:
    """Seconds of processor time of a peer for a chain of `size` sections; None with the reason where there are none."""

    peer: str
    size: int
    seconds: float | None
    reason: str = ""

    def __str__(self) -> str:
        return f"  {self.peer:<15} N = {self.size:>4}: " + (
            self.reason if self.seconds is None else f"{self.seconds:.1f} s"
        )


def measure_peers() -> list[PeerTime]:
    """Every peer over growing chains, until it is missing, fails or takes longer than the limit."""
    found: list[PeerTime] = []
    for peer, program in (("BondGraphTools", BOND_GRAPH_TOOLS), ("bondgraph", BONDGRAPH)):
        for size in SIZES:
            found.append(_measure(peer, program, size))
            if found[-1].seconds is None:
                break
    return found


def _measure(peer: str, program: str, size: int) -> PeerTime:
    command = [sys.executable, "-c", program, str(size)]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return PeerTime(peer, size, None, f"not within {LIMIT_S:g} s")
    if answer.returncode:
        return PeerTime(peer, size, None, f"not measured: {answer.stderr.strip().splitlines()[-1]}")
    return PeerTime(peer, size, float(answer.stdout.split()[-1]))
