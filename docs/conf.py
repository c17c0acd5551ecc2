"""Settings of Sphinx; `make docs` builds the pages."""

import re
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS))

project = "propermodel"
author = "propermodel developers"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "gallery_pages", "law_pages", "math_markup"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "force"  # notebooks are kept without outputs
nb_execution_raise_on_error = True
nb_execution_timeout = 120  # s, of a cell
nb_execution_in_temp = True
html_theme = "furo"
html_title = "propermodel"
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["formulas.css", "gallery.css"]
html_show_copyright = False
exclude_patterns = ["_build", "decisions"]
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
# Docstrings are written to be read in an editor; long formulas stand in indented blocks of their own.
MARKED = re.compile(r"(``.+?``|`[^`]+`)")
# What reStructuredText would take for emphasis, a substitution or a link.
MEANT = re.compile(r"[*|\\]|\w_(?=\W|$)")


def plain_words(text: str) -> str:
    """A line of a docstring as reStructuredText that means what it says: code in backticks, the rest as it is."""
    pieces = MARKED.split(text)
    for place, piece in enumerate(pieces):
        if place % 2:
            plural = "\\ " if pieces[place + 1][:1].isalnum() else ""
            pieces[place] = f"``{piece.strip('`')}``{plural}"
        else:
            pieces[place] = MEANT.sub(lambda match: match[0][:-1] + "\\" + match[0][-1], piece)
    return "".join(pieces)


def escape_docstring(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep the lines of a docstring, escaped; what stands indented after a blank line is a literal block."""
    result: list[str] = []
    literal = False
    for number, line in enumerate(lines):
        indented = line.startswith(" ") and not line.lstrip().startswith((":", "*"))
        starts = indented and (number == 0 or not lines[number - 1].strip()) and not _in_field(lines, number)
        if starts and not literal:
            result.extend(["::", ""])
            literal = True
        elif literal and line.strip() and not line.startswith(" "):
            literal = False
        result.append(line if literal or line.lstrip().startswith(":") else plain_words(line))
    lines[:] = result


def _in_field(lines: list[str], number: int) -> bool:
    """Whether an indented line goes on a field list, such as the arguments of a function."""
    for line in reversed(lines[:number]):
        if line.strip() and not line.startswith(" "):
            return line.startswith(":")
    return False


def add_loose_pages(app: object, docname: str, source: list[str]) -> None:
    """Put top-level pages that the index does not name at the end of its last table of contents."""
    if docname == "index":
        named = set(source[0].splitlines())
        loose = sorted({page.stem for page in DOCS.glob("*.md")} - named - {"index"})
        head, fence, tail = source[0].rpartition("```")
        source[0] = head + "".join(f"{name}\n" for name in loose) + fence + tail


def setup(app: object) -> None:
    """Escape docstrings after napoleon has made fields of arguments and errors."""
    app.connect("autodoc-process-docstring", escape_docstring, priority=900)  # type: ignore[attr-defined]
    app.connect("source-read", add_loose_pages)  # type: ignore[attr-defined]
