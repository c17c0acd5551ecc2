"""Every code block of the documentation runs, and prints what the page says.

The blocks of a page run in order in one namespace and one empty folder, beside the examples. A `python` block followed
by a `text` block must print that text; any other `text` block is an illustration. The commands of a `sh` block must
succeed.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

import propermodel
from propermodel.cli.app import app

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(
    str(page.relative_to(DOCS)) for folder in (".", "howto", "explanation") for page in (DOCS / folder).glob("*.md")
)
BLOCK = re.compile(r"^```(python|text|sh)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def blocks(page: str) -> list[tuple[str, str]]:
    return [(match[1], match[2]) for match in BLOCK.finditer((DOCS / page).read_text(encoding="utf-8"))]


def slow(page: str) -> bool:
    return page == "truck.md"  # its commands drive the truck for 2200 s; the paper tests hold its figures


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page) and not slow(page)])
def test_the_blocks_of_a_page_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "examples").symlink_to(ROOT / "examples", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    printed: str | None = None
    for language, text in blocks(page):
        if language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as output:
                exec(compile(text, page, "exec"), names)
            printed = output.getvalue()
        elif language == "text":
            if printed is not None:
                assert printed.strip() == text.strip()
            printed = None
        else:
            for line in text.splitlines():
                command, *arguments = shlex.split(line)
                assert command == "propermodel"
                done = CliRunner().invoke(app, arguments)
                assert done.exit_code == 0, f"{line}\n{done.output}"


def test_every_page_of_a_folder_is_in_the_table_of_contents():
    entries = (DOCS / "index.md").read_text(encoding="utf-8").splitlines()
    for page in PAGES:
        assert "/" not in page or page.removesuffix(".md") in entries, page


def test_the_reference_describes_every_public_name_once():
    text = (DOCS / "reference" / "api.md").read_text(encoding="utf-8")
    described = re.findall(r"^\.\. (?:autoclass|autofunction|py:data):: propermodel\.(\w+)$", text, re.MULTILINE)
    assert sorted(described) == sorted(propermodel.__all__)
