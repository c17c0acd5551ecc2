"""`python -m benchmarks.galleries`: searches on systems with known answers, and writes `docs/reduction_galleries.md`.

What was found is kept in `out/bench/galleries.jsonl`, one line for each system, and is not found anew with `--resume`;
what is true is kept in `out/bench/galleries/`, and judged anew with `--judge`.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np

from benchmarks.conditions import conditions
from benchmarks.galleries.bent import draw_bent_gallery
from benchmarks.galleries.cases import as_data, cases_of, forecast_of
from benchmarks.galleries.exhaustion import Exhaustion, exhaust
from benchmarks.galleries.families import draw_gallery
from benchmarks.galleries.march import exhaust_bent
from benchmarks.galleries.network import Network
from benchmarks.galleries.page import told, write_page
from benchmarks.measure import Json

COMMAND = "python -m benchmarks.galleries"
DATA = Path("out/bench/galleries.jsonl")
TRUTHS = Path("out/bench/galleries")
PAGE = Path("docs/reduction_galleries.md")
FULL = {"linear": 110, "bent": 33}
QUICK = {"linear": 18, "bent": 4}
MOST_ELEMENTS = {"linear": 7, "bent": 6}  # of systems, unless all are asked for

Judge = Callable[[Network], Exhaustion]


def main() -> None:
    """Search, compare with what is true, write the page."""
    options = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    options.add_argument("--full", action="store_true", help="all systems, in about half an hour")
    options.add_argument("--only", choices=("linear", "bent"), help="one gallery; the other's part of the page stays")
    options.add_argument("--resume", action="store_true", help="keep what an earlier call has found")
    options.add_argument("--judge", action="store_true", help="judge all sets anew")
    options.add_argument("--page", type=Path, help=f"the page to write (with --full by default {PAGE})")
    options.add_argument("--seed", type=int, default=1, help="of the galleries (default: 1)")
    asked = options.parse_args()
    TRUTHS.mkdir(parents=True, exist_ok=True)
    if asked.judge:
        for file in TRUTHS.glob("*.npz"):
            file.unlink()
    if not asked.resume:
        DATA.unlink(missing_ok=True)
    galleries = galleries_of(asked.seed, is_full=asked.full)
    galleries = {kind: gallery for kind, gallery in galleries.items() if asked.only in (None, kind)}
    for kind, (networks, judge) in galleries.items():
        known = {line["system"] for line in _lines() if line["kind"] == kind}
        for network in networks:
            if network.name not in known:
                found = {
                    "kind": kind,
                    "system": network.name,
                    **findings(network, truth_of(network, judge, asked.seed)),
                }
                with DATA.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(found) + "\n")
                print(_progress(found), file=sys.stderr, flush=True)
    data = gathered(_lines(), {network.name for networks, _ in galleries.values() for network in networks})
    words = [COMMAND, *["--full"] * asked.full, *([] if asked.only is None else [f"--only {asked.only}"])]
    data |= {"command": " ".join(words), "conditions": conditions()}
    print(told(data))
    page = asked.page or (PAGE if asked.full else None)
    if page is not None:
        write_page(data, page)


def galleries_of(seed: int, *, is_full: bool) -> Mapping[str, tuple[list[Network], Judge]]:
    """The networks of either gallery, and what judges them."""
    sizes = FULL if is_full else QUICK
    linear, bent = draw_gallery(sizes["linear"], seed), draw_bent_gallery(sizes["bent"], seed)

    def chosen(kind: str, networks: list[Network]) -> list[Network]:
        return [n for n in networks if is_full or len(n.elements) <= MOST_ELEMENTS[kind]]

    return {"linear": (chosen("linear", linear), exhaust), "bent": (chosen("bent", bent), exhaust_bent)}


def truth_of(network: Network, judge: Judge, seed: int) -> Exhaustion:
    """What is true of a network, from its file if there is one."""
    file = TRUTHS / f"{network.name}_{seed}.npz"
    if not file.exists():
        found = judge(network)
        np.savez_compressed(file, meanings=found.meanings, errors=found.errors.astype(np.float32), tried=found.tried)
    with np.load(file) as kept:
        return Exhaustion(kept["meanings"], kept["errors"].astype(np.float64), (), int(kept["tried"]))


def findings(network: Network, truth: Exhaustion) -> Json:
    """The cases and the predictions of one network, as plain data."""
    return {
        "forecast": as_data(forecast_of(network, truth)),
        "cases": [as_data(case) | {"missed": case.missed} for case in cases_of(network, truth)],
    }


def gathered(lines: Iterable[Json], names: set[str]) -> Json:
    """What the lines of some networks say, by gallery."""
    data: Json = {}
    for line in lines:
        if line["system"] in names:
            part = data.setdefault(line["kind"], {"cases": [], "forecasts": []})
            part["cases"] += line["cases"]
            part["forecasts"].append(line["forecast"])
    return data


def _lines() -> list[Json]:
    return [json.loads(line) for line in DATA.read_text(encoding="utf-8").splitlines()] if DATA.exists() else []


def _progress(found: Json) -> str:
    cases = ", ".join(
        f"{c['tolerance']:.1%}: {c['found']} of {c['optimum']} with {c['simulations']} runs" for c in found["cases"]
    )
    return f"{found['system']}: {cases}"


if __name__ == "__main__":
    main()
