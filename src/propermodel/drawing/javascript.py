"""The JavaScript engine inside Python that runs the drawing code without a browser."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from importlib import import_module, resources
from typing import Any

from propermodel.diagnostics import ProperModelError

# What a page would offer: time-outs become tasks that are run in order, and nothing is printed.
_SURROUNDINGS = """
globalThis.self = globalThis;
globalThis.console = { log() {}, info() {}, warn() {}, error() {} };
const waiting = [];
globalThis.setTimeout = (task, _delay, ...rest) => waiting.push(() => task(...rest));
globalThis.clearTimeout = () => {};
globalThis.runWaiting = () => {
  const tasks = waiting.splice(0);
  tasks.forEach((task) => task());
  return tasks.length;
};
globalThis.document = {};  // so that ELK does not take this for a worker
globalThis.exports = {};
globalThis.module = { exports };
globalThis.answer = null;
globalThis.keep = (promise) => {
  answer = null;
  promise.then((text) => { answer = { text }; }, (fault) => { answer = { fault: `${fault}` }; });
};
"""
_local = threading.local()  # an engine belongs to one thread


class DrawingError(ProperModelError):
    """A picture cannot be drawn."""


def run_drawing(picture: Mapping[str, object], options: Mapping[str, object]) -> str:
    """The SVG text of a picture document.

    Raises:
        DrawingError: the JavaScript engine is not installed, or the document is no picture.
    """
    context: Any = getattr(_local, "context", None)
    if context is None:
        context = _local.context = _started()
    context.set("picture", json.dumps(picture))
    context.set("options", json.dumps(options))
    context.eval("keep(drawPicture(picture, options))")
    while context.execute_pending_job() or context.eval("runWaiting()"):
        pass
    # A text that was put together from parts only comes out whole as JSON.
    answer: dict[str, str] | None = json.loads(context.eval("JSON.stringify(answer)"))
    if answer is None or "fault" in answer:
        raise DrawingError.of(
            "drawing/failed",
            "the picture cannot be drawn",
            where="" if answer is None else answer["fault"],
            help="give a picture that `depict` made; if it is one, please report it with its document",
        )
    return answer["text"]


def _started() -> Any:
    try:
        quickjs = import_module("quickjs")
    except ImportError as error:
        raise DrawingError.of(
            "drawing/javascript",
            "drawing without a browser needs the package quickjs-ng, which is not installed",
            help="install it: pip install 'propermodel[draw]'",
        ) from error
    context: Any = quickjs.Context()
    context.eval(_SURROUNDINGS)
    assets = resources.files("propermodel.drawing") / "assets"
    context.eval((assets / "elk-worker.min.js").read_text(encoding="utf-8"))
    context.eval("globalThis.ElkWorker = module.exports.Worker")
    context.eval((assets / "drawing.js").read_text(encoding="utf-8"))
    return context
