"""Writes `docs/reduction_galleries.md` from what was found."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from benchmarks.galleries.summary import Prediction, Tally, prediction_of, tally
from benchmarks.measure import Json
from benchmarks.part import paragraph, table

_HEAD = (
    "How often `find_proper_model` finds the smallest model there is, and how well `predict_errors` knows what a",
    "removal costs, on systems for which the answer is known: every subset of their elements, with every meaning of",
    "a removal, was judged by a solver that shares no code with the package. `python -m benchmarks.galleries",
    "--full` writes this page; without `--full` it takes a few systems and some minutes.",
)
_LINEAR = (
    "Systems of 6 to 12 energy elements drawn by chance: chains and trees of bodies, cars, drivelines with gears,",
    "electrical ladders, hydraulic circuits, motors, hydrostatic drives; half with parameters within a factor of 2",
    "of usual values, half within a factor of 16. Some carry a weight, a load or a supply pressure all the time; in",
    "some a coil and a capacitor, or a body and its spring, cancel each other. Each is driven by a step, a pulse,",
    "sines or noise, and one or two efforts or flows are asked for. Truth is exhaustive over keep, no effort, no",
    "flow, and the mean effort or flow of storage (in all systems with up to 60,000 sets, beyond that where",
    "something is biased), by exact responses on a damped Fourier transform. Sets are left out only where they have",
    "no solution.",
)
_BENT = (
    "The same with up to three laws that bend by a factor of two and more over the run: hardening springs,",
    "saturating and quadratic dampers, smooth dry friction, orifices; in some of them under a load all the time, from",
    "their rest under it. Truth is exhaustive by time steps (TR-BDF2), all models of a system side by side, given up",
    "when they are proved to be outside by a factor of two.",
)
_MEASURE = (
    "An error is the root mean square of the change of an output as a share of its range in the full run; the",
    "largest over the outputs counts. Tolerances are 1, 2 and 5 %, each moved up until no error of a decisive model",
    "is within 2 % of it, so that neither side decides by rounding.",
)
_PREDICTION = (
    "For every element the best single removal: its error as predicted from one run of the full model, and as it",
    "is. Spearman's coefficient of both within each system, beside that of activity; and the share of all single",
    "removals (whose true error lies between 0.01 and 100 %) predicted within a factor of 2.",
)


_SECTIONS = {"linear": ("Linear systems", _LINEAR), "bent": ("Systems that are not linear", _BENT)}


def write_page(data: Json, file: Path) -> None:
    """Write the page; what is said of a gallery that was not looked at stays as it is."""
    kept = file.read_text(encoding="utf-8") if file.exists() else ""
    lines = ["# Galleries with known answers", "", paragraph(*_HEAD), "", paragraph(*_MEASURE), ""]
    for key, (title, words) in _SECTIONS.items():
        found = data.get(key)
        if not found:
            lines += _section(kept, title)
            continue
        lines += [f"## {title}", "", paragraph(*words), ""]
        lines += _search_lines(found["cases"])
        lines += [paragraph(*_PREDICTION), "", *_prediction_lines(prediction_of(found["forecasts"]))]
        lines += _misses(found["cases"])
        machine = data["conditions"]
        lines += [
            paragraph(
                f"*`{data['command']}`, {machine['date']}: {machine['processor']}, {machine['cores']} cores; "
                f"Python {machine['python']}, numpy {machine['packages']['numpy']}.*"
            ),
            "",
        ]
    text = "\n".join(lines)
    while "\n\n\n" in text:
        text = text.replace("\n\n\n", "\n\n")
    file.write_text(text.rstrip() + "\n", encoding="utf-8")


def _section(page: str, title: str) -> list[str]:
    """A section of a page, without its head and tail."""
    _, found, rest = page.partition(f"## {title}\n")
    return [f"## {title}", *rest.partition("\n## ")[0].rstrip().splitlines(), ""] if found else []


def _search_lines(cases: Sequence[Json]) -> list[str]:
    groups: Mapping[str, Callable[[Json], bool]] = {
        "all": lambda _: True,
        "can lose three or more": lambda c: c["optimum"] >= 3,
        "8 elements and more": lambda c: c["elements"] >= 8,
        "biased": lambda c: c["is_biased"],
        "cancelling pairs": lambda c: c["family"] in ("resonant branch", "tuned cradle"),
    }
    tallies = {name: tally([c for c in cases if is_in(c)]) for name, is_in in groups.items()}
    head = ["cases", "number", "optimum", "one more", "two more", "outside", "simulations", "at most", "of all sets"]
    rows = [_row(name, found) for name, found in tallies.items() if found.cases]
    whole = tallies["all"]
    systems = len({c["system"] for c in cases})
    told = paragraph(
        f"{systems} systems, {whole.cases} cases, {sum(c['exhaustive'] for c in cases) // 3:,} sets judged for",
        "the truth. *Optimum* counts models with as few elements as any within the tolerance",
        f"({whole.smaller} of them with fewer than the sets that were judged, by a constant that was not among them);",
        "*outside* counts errors beyond the tolerance by simulation, or by the judge, who knows",
        f"{whole.judged} of the models found;",
        "*simulations* is the median with the 90 % quantile; *at most* the largest number of simulations for each",
        "element; *of all sets* the largest share of simulations in the sets.",
    )
    return [told, *table(head, rows)]


def _row(name: str, found: Tally) -> list[str]:
    return [
        name,
        str(found.cases),
        f"{found.optimum / found.cases:.1%}",
        str(found.one_more),
        str(found.two_more),
        str(found.outside),
        f"{found.simulations:.0f} / {found.many_simulations:.0f}",
        f"{found.most_each:.1f}",
        f"{found.largest_share:.2%}",
    ]


def _prediction_lines(found: Prediction) -> list[str]:
    head = ["", "median", "10 % quantile", "within a factor of 2"]
    rows = [
        ["predicted error", f"{found.median:.3f}", f"{found.low:.3f}", f"{found.within_two:.1%}"],
        ["activity", f"{found.activity_median:.3f}", f"{found.activity_low:.3f}", ""],
    ]
    return table(head, rows)


def _misses(cases: Sequence[Json]) -> list[str]:
    missed = [case for case in cases if case["missed"] > 0]
    if not missed:
        return ["No case was missed.", ""]
    head = ["missed", "tolerance", "found", "optimum", "removed", "could be removed", "its error"]
    rows = [
        [
            f"`{case['system']}`",
            f"{case['tolerance']:.2%}",
            str(case["found"]),
            str(case["optimum"]),
            ", ".join(case["removals"]) or "nothing",
            ", ".join(case["best"]),
            _best_error(case["best_error"]),
        ]
        for case in missed
    ]
    words = paragraph(
        "*Its error* is that of the set that could be removed, over the tolerance, as the package simulates it; where",
        "it is more than one, the judge was wrong, and not the search; *none* where the package refuses what would be",
        "left.",
    )
    return [*table(head, rows, numbers_from=6), words, ""]


def _best_error(error: float | None) -> str:
    if error is None:
        return ""
    return f"{error:.2f}" if math.isfinite(error) else "none"


def told(data: Json) -> str:
    """The figures of all parts in a few lines, for the terminal."""
    lines: list[str] = []
    for key in ("linear", "bent"):
        if found := data.get(key):
            whole, forecast = tally(found["cases"]), prediction_of(found["forecasts"])
            lines.append(
                f"{key}: {whole.cases} cases, optimum {whole.optimum / whole.cases:.1%}, one more {whole.one_more}, "
                f"two more {whole.two_more}, outside {whole.outside}; Spearman {forecast.median:.3f} "
                f"(activity {forecast.activity_median:.3f}), within a factor of 2 {forecast.within_two:.1%}"
            )
    return "\n".join(lines)
