"""One small model or call for each code of a diagnostic, and what its text must tell."""

from __future__ import annotations

import linecache
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from propermodel import Component, ModelWarning, compile_model, elaborate
from propermodel.diagnostics import Diagnostic, ProperModelError

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True, kw_only=True)
class Case:
    """A fault that an author or user makes.

    `run` makes the fault through the public interface: it raises, gives warnings, or gives what a command has printed.
    `names` must stand in the text, `at` in the author's line that is pointed at, `cure` in the help.
    """

    code: str
    run: Callable[[], object]
    names: tuple[str, ...] = ()
    at: str = ""
    cure: str = ""

    def text(self) -> str:
        """What the person who made the fault reads about this code."""
        found = self.found()
        if isinstance(found, str):
            return found
        assert [d.code for d in found if d.code != self.code] == [], [str(d) for d in found]
        return str(found[0])

    def found(self) -> str | tuple[Diagnostic, ...]:
        """The diagnostics, or the text that a command printed."""
        try:
            result = self.run()
        except ProperModelError as error:
            return error.diagnostics
        if isinstance(result, str):
            return result
        assert isinstance(result, tuple), f"{self.code}: nothing was raised, {result!r} was given"
        assert result, f"{self.code}: no warning was given"
        return result

    def lines_pointed_at(self, text: str) -> list[str]:
        """The lines of source files whose places stand in a text."""
        places = re.findall(r"([\w/.-]+\.py):(\d+)", text)
        return [linecache.getline(str(ROOT / file), int(line)).strip() for file, line in places]


def warned(component: Component) -> tuple[Diagnostic, ...]:
    """The warnings that compiling a model shows."""
    with pytest.warns(ModelWarning) as shown:
        compiled = compile_model(elaborate(component))
    assert [str(warning.message) for warning in shown] == [str(diagnostic) for diagnostic in compiled.warnings]
    return compiled.warnings
