"""Makes a page for every example, with its docstring, its source, what it prints and a picture of its run.

Runs before Sphinx reads its sources, and writes into `docs/gallery`, which is not kept.
"""

import contextlib
import io
import runpy
import sys
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
GALLERY = DOCS / "gallery"
SECTIONS = {
    frozenset({"electrical"}): "Circuits",
    frozenset({"translation"}): "Bodies on a line",
    frozenset({"rotation"}): "Shafts",
    frozenset({"rotation", "translation"}): "Mechanisms and vehicles",
    frozenset({"hydraulic"}): "Hydraulics",
    frozenset({"thermal"}): "Heat",
}
SEVERAL = "Several domains"
FEW = 8  # states whose equations a page shows
LONGEST = 6000  # characters of them


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("builder-inited", lambda _: write_gallery())
    return {"parallel_read_safe": True}


def write_gallery() -> None:
    """A page for every example, and one that shows them all by domain."""
    import matplotlib as mpl

    mpl.use("Agg")
    sys.path.insert(0, str(DOCS.parent))
    GALLERY.mkdir(exist_ok=True)
    cards: dict[str, list[str]] = {title: [] for title in (*SECTIONS.values(), SEVERAL)}
    names = sorted(path.stem for path in EXAMPLES.glob("[a-z]*.py"))
    for name in names:
        module, printed = run(name)
        title = write_page(name, module, printed)
        section = SECTIONS.get(frozenset(domains(module["answer"].compiled.model.root)), SEVERAL)
        cards[section].append(f"- [![]({name}.png)<br>{title}]({name}.md)")
    page = [
        "# Gallery",
        (
            "Textbook systems, one idea each, to be read, run and changed: `python examples/rlc.py`, or\n"
            "`propermodel run examples/rlc.py`. Each is tested against a closed form or an independent solution."
        ),
    ]
    for title, rows in cards.items():
        page += [f"## {title}", "\n".join(["```{container} gallery", *rows, "```"])]
    page.append("\n".join(["```{toctree}", ":hidden:", *names, "```"]))
    write(GALLERY / "index.md", "\n\n".join(page) + "\n")


def run(name: str) -> tuple[dict[str, Any], str]:
    """The names of an example that has run, and what it printed."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        module = runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    return module, printed.getvalue().strip()


def domains(part: Any) -> set[str]:
    """The domains of the ports of a part and of all parts inside it."""
    inside = [domains(other) for other in part.definition.parts]
    return {port.domain for port in part.definition.ports}.union(*inside)


def write_page(name: str, module: dict[str, Any], printed: str) -> str:
    """The page and picture of one example; gives its title."""
    draw(module, GALLERY / f"{name}.png")
    title, _, idea = (module["__doc__"] or "").strip().partition("\n")
    source = (EXAMPLES / f"{name}.py").read_text(encoding="utf-8").split('"""', 2)[2].strip()
    page = [
        f"# {title.rstrip('.')}",
        idea.strip(),
        f"![What {name} does over time]({name}.png)",
        *equations(module),
        f"## The model: `examples/{name}.py`",
        f"```python\n{source}\n```",
        "## What it prints",
        f"```text\n{printed}\n```",
    ]
    write(GALLERY / f"{name}.md", "\n\n".join(page) + "\n")
    return title.rstrip(".")


def equations(module: dict[str, Any]) -> list[str]:
    """The state equations of an example, where they are few."""
    from propermodel.equations.readable import state_equations

    readable = state_equations(module["answer"].compiled)
    written = readable.markdown().partition("\n")[2].strip()
    return ["## Its equations", written] if len(readable.states) <= FEW and len(written) <= LONGEST else []


def draw(module: dict[str, Any], file: Path) -> None:
    """The outputs of an example over time, one panel for each unit."""
    from matplotlib.figure import Figure

    run, outputs = module["answer"], module["OUTPUTS"]
    units = list(dict.fromkeys(run.unit(output) for output in outputs))
    figure = Figure(figsize=(7.0, 1.2 + 1.8 * len(units)), layout="constrained")
    for place, unit in enumerate(units, 1):
        axes = figure.add_subplot(len(units), 1, place)
        for output in outputs:
            if run.unit(output) == unit:
                axes.plot(run.time, run[output], label=output, linewidth=1.2)
        axes.set_ylabel(unit or "1")
        axes.grid(alpha=0.3)
        axes.legend(
            fontsize="small", frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderpad=0.0
        )
    figure.axes[-1].set_xlabel("time, s")
    figure.savefig(file, dpi=110)


def write(file: Path, text: str) -> None:
    """Write only what has changed, so that Sphinx reads no page twice."""
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        file.write_text(text, encoding="utf-8")
