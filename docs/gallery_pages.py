"""Makes a page for every example, with its docstring, its source, what it prints and a picture of its run.

Runs before Sphinx reads its sources, and writes into `docs/gallery`, which is not kept.
"""

import contextlib
import io
import runpy
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
GALLERY = DOCS / "gallery"
FEW = 8  # states whose equations a page shows
LONGEST = 6000  # characters of them


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("builder-inited", lambda _: write_gallery())
    return {"parallel_read_safe": True}


def write_gallery() -> None:
    """A page for every example and one that lists them."""
    import matplotlib as mpl

    mpl.use("Agg")
    sys.path.insert(0, str(DOCS.parent))
    GALLERY.mkdir(exist_ok=True)
    names = sorted(path.stem for path in EXAMPLES.glob("[a-z]*.py"))
    titles = {name: write_page(name) for name in names}
    rows = [f"- [{titles[name]}]({name}.md) (`examples/{name}.py`)" for name in names]
    tree = ["```{toctree}", ":hidden:", *names, "```"]
    head = [
        "# Gallery",
        "",
        "Textbook systems, one idea each, to be read, run and changed: `python examples/rlc.py`, or",
        "`propermodel run examples/rlc.py`. Each is tested against a closed form or an independent solution.",
        "",
    ]
    write(GALLERY / "index.md", "\n".join([*head, *rows, "", *tree, ""]))


def write_page(name: str) -> str:
    """The page and picture of one example; gives its title."""
    file = EXAMPLES / f"{name}.py"
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        module = runpy.run_path(str(file), run_name="__main__")
    draw(module, GALLERY / f"{name}.png")
    title, _, idea = (module["__doc__"] or "").strip().partition("\n")
    source = file.read_text(encoding="utf-8").split('"""', 2)[2].strip()
    page = [
        f"# {title.rstrip('.')}",
        idea.strip(),
        f"![What {name} does over time]({name}.png)",
        *equations(module),
        f"## The model: `examples/{name}.py`",
        f"```python\n{source}\n```",
        "## What it prints",
        f"```text\n{printed.getvalue().strip()}\n```",
    ]
    write(GALLERY / f"{name}.md", "\n\n".join(page) + "\n")
    return title.rstrip(".")


def equations(module: dict[str, Any]) -> list[str]:
    """The state equations of an example, where they are few."""
    from propermodel.equations.readable import state_equations

    readable = state_equations(module["answer"].compiled)
    written = readable.markdown().partition("\n")[2].strip()
    return ["## Its equations", written] if len(readable.states) <= FEW and len(written) <= LONGEST else []


def draw(module: dict[str, Any] | ModuleType, file: Path) -> None:
    """The outputs of an example over time, one panel for each unit."""
    from matplotlib.figure import Figure

    names = dict(module)  # type: ignore[call-overload]
    run, outputs = names["answer"], names["OUTPUTS"]
    units = list(dict.fromkeys(run.unit(output) for output in outputs))
    figure = Figure(figsize=(7.0, 1.2 + 1.8 * len(units)), layout="constrained")
    for place, unit in enumerate(units, 1):
        axes = figure.add_subplot(len(units), 1, place)
        for output in outputs:
            if run.unit(output) == unit:
                axes.plot(run.time, run[output], label=output, linewidth=1.2)
        axes.set_ylabel(unit or "1")
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small", frameon=False)
    figure.axes[-1].set_xlabel("time, s")
    figure.savefig(file, dpi=110)


def write(file: Path, text: str) -> None:
    """Write only what has changed, so that Sphinx reads no page twice."""
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        file.write_text(text, encoding="utf-8")
