"""What an author may write in `events()`, and what a document may hold of it."""

from __future__ import annotations

from dataclasses import replace as changed
from typing import Any

import pytest

from propermodel import Component, Discrete, Expr, Path, Port, Resistance, Translation, elaborate, when
from propermodel.diagnostics import DocumentError, ModelError
from propermodel.expressions.core import SymbolKind, symbol
from propermodel.modelling.documents import from_document, to_document
from propermodel.modelling.model import Event, Model
from tests.event_parts import BouncingBall, SlowingMass
from tests.parts import Mass


def element(events: Any) -> type[Resistance]:
    """A damper with these events."""

    class Latch(Resistance):
        flange = Port(Translation)
        mode = Discrete("")
        pull = Discrete("N")

        def effort(self, flow: Expr) -> Expr:
            return self.pull * (1.0 + 0.0 * self.mode)

        def flow(self, effort: Expr) -> float:
            return 0.0

    Latch.events = events  # pyright: ignore[reportAttributeAccessIssue]
    return Latch


def faults(events: Any) -> str:
    with pytest.raises(ModelError) as caught:
        elaborate(element(events)())
    return str(caught.value)


def test_events_become_data_with_the_line_of_their_author():
    damper = next(p for p in elaborate(SlowingMass()).root.definition.parts if p.name == "damper").definition
    assert [name for name, _, _ in damper.discretes] == ["stage"]
    (event,) = damper.events
    ((target, _),) = event.changes
    assert (target.data.kind, target.data.path) == (SymbolKind.DISCRETE, Path(("stage",)))
    assert event.source.file.endswith("event_parts.py")


def test_a_stored_quantity_is_meant_as_the_state_of_its_storage():
    ball = next(p for p in elaborate(BouncingBall()).root.definition.parts if p.name == "ball").definition
    ((target, _),) = ball.events[0].changes
    assert (target.data.kind, target.data.path) == (SymbolKind.STATE, Path(("momentum",)))


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (lambda self: when(self.mode > 0.5, {self.mode: 0.0}), "as a sequence"),
        (lambda self: (self.mode > 0.5,), "something other than when"),
        (lambda self: (when(self.mode, {self.mode: 0.0}),), "condition is a number"),
        (lambda self: (when(self.mode > 0.5, {}),), "changes nothing"),
        (lambda self: (when(self.mode > 0.5, {self.flange.effort: 0.0}),), "flange.effort"),
        (lambda self: (when(self.mode > 0.5, {self.flange.momentum: 0.0}),), "flange.momentum"),
        (lambda self: (when(self.mode > 0.5, {self.mode + 1.0: 0.0}),), "no state or discrete value"),
    ],
)
def test_what_is_no_event_is_refused(events: Any, message: str):
    text = faults(events)
    assert "error[model/event]" in text
    assert message in text
    assert "help: " in text


@pytest.mark.parametrize(
    "events",
    [
        lambda self: (when(self.pull > self.flange.flow, {self.mode: 0.0}),),
        lambda self: (when(self.mode > 0.5, {self.pull: self.flange.flow}),),
    ],
)
def test_conditions_and_values_are_checked_for_their_dimensions(events: Any):
    assert "error[model/dimension]" in faults(events)


def test_a_composite_has_no_events():
    class Rig(Component):
        mass = Mass(mass=1.0)

        def events(self):
            return (when(self.mass.flange.flow > 0.0, {self.mass.flange.momentum: 0.0}),)

    with pytest.raises(ModelError, match="only an element or a signal block"):
        elaborate(Rig())


def with_event(event: Event) -> Model:
    model = elaborate(SlowingMass())
    parts = tuple(
        changed(part, definition=changed(part.definition, events=(event,))) if part.name == "damper" else part
        for part in model.root.definition.parts
    )
    return changed(model, root=changed(model.root, definition=changed(model.root.definition, parts=parts)))


STAGE = symbol(SymbolKind.DISCRETE, Path(("stage",)))
FLOW = symbol(SymbolKind.FLOW, Path(("flange", "flow")), "m/s")


@pytest.mark.parametrize(
    ("event", "message"),
    [
        (Event(condition=STAGE, changes=((STAGE, STAGE),)), "must be a condition"),
        (Event(condition=STAGE > 1.0, changes=((FLOW, FLOW),)), "no state or discrete value of its own"),
        (Event(condition=STAGE > 1.0, changes=((STAGE + 1.0, STAGE),)), "no state or discrete value of its own"),
        (Event(condition=STAGE > 1.0, changes=()), "changes nothing"),
        (Event(condition=symbol(SymbolKind.STATE, Path(("x",))) > 1.0, changes=((STAGE, STAGE),)), "does not exist"),
    ],
)
def test_a_document_whose_events_do_not_fit_is_refused(event: Event, message: str):
    document = to_document(with_event(event))
    with pytest.raises(DocumentError, match=message):
        from_document(document)
