"""How a search goes on in a large model, where true errors jump from one set of removals to the next."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

import propermodel as pm
from propermodel.analysis.comparison import Comparison
from propermodel.diagnostics import Path
from propermodel.reduction.candidates import Candidate, Verdict
from propermodel.reduction.proposals import Choice, Proposed, removals_of, sorted_by_score
from propermodel.reduction.strategy import Strategy
from propermodel.reduction.trials import Prepared, Trials

ROWS = [Path((name,)) for name in "abcdefgh"]


def choice_of(rows: Iterable[Path]) -> Choice:
    return {row: (pm.ZeroEffort(row / "port"),) for row in rows}


class Scripted:
    """Proposals and trials of a model of which everything is known: what is predicted, and what comes true."""

    is_large = True

    def __init__(self, true: dict[str, float]) -> None:
        self.true = true
        self.proposals = self
        self.judged: list[str] = []

    def beam(self) -> dict[int, list[Proposed]]:
        return {len(ROWS): [Proposed(choice_of(ROWS), 0.9)]}

    def restored(self, choice: Choice) -> list[Proposed]:
        fewer = ([row for row in choice if row != back] for back in choice)
        return [Proposed(choice_of(rows), 0.5 + 0.01 * k) for k, rows in enumerate(fewer)]

    def refused_part(self, removals: object) -> None:
        return None

    def is_refused(self, removals: object) -> bool:
        return False

    def root(self) -> None:
        return None

    def node(self, choice: Choice) -> None:
        return None

    def prepare(self, node: Proposed) -> Prepared:
        return Prepared(node, tuple(removals_of(node.choice)), cast("Any", None), name_of(node.choice))

    def judge(self, prepared: Prepared) -> tuple[Candidate, int]:
        name = name_of(prepared.node.choice)
        self.judged.append(name)
        score = self.true.get(name, 1.5)
        candidate = Candidate(
            rows=tuple(prepared.node.choice),
            removals=prepared.removals,
            predicted=prepared.node.score,
            score=score,
            verdict=Verdict.WITHIN if score <= 1.0 else Verdict.OUTSIDE,
            why="",
            states=1,
            comparisons={"scenario": Comparison(())} if score < 10.0 else {},
        )
        return candidate, 1


def name_of(choice: Choice) -> str:
    return "".join(sorted(map(str, choice)))


def searched(true: dict[str, float]) -> tuple[Scripted, list[Candidate]]:
    script = Scripted(true)
    strategy = Strategy(cast("Trials", script), 100, None)
    strategy.run()
    return script, list(strategy.tried.values())


def test_beside_a_near_miss_the_same_with_one_row_back_is_tried():
    script, tried = searched({"abcdefgh": 1.2, "abcefgh": 0.7})
    assert script.judged[0] == "abcdefgh"
    assert [name_of(choice_of(c.rows)) for c in tried if c.verdict is Verdict.WITHIN] == ["abcefgh"]


def test_beside_what_was_proved_outside_early_nothing_is_tried():
    script, _ = searched({"abcdefgh": 50.0, "abcefgh": 0.7})
    assert script.judged == ["abcdefgh"]


def test_of_sets_with_one_predicted_error_the_first_is_tried_before_others():
    scores = {"a": 0.30001, "b": 0.3, "c": 0.5, "d": 0.0, "e": 0.30002}
    nodes = [Proposed(choice_of([Path((name,))]), score) for name, score in scores.items()]
    assert [name_of(node.choice) for node in sorted_by_score(nodes)] == ["d", "b", "c", "a", "e"]
