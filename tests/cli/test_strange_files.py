"""Files from strangers are refused by every command."""

from pathlib import Path

import pytest

from propermodel.modelling.documents import write_model
from tests.cli.commands import _model, fail, invoke


@pytest.fixture(scope="module")
def strange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("strange")
    write_model(_model(), folder / "whole.json")
    whole = (folder / "whole.json").read_bytes()
    (folder / "truncated.json").write_bytes(whole[: len(whole) // 2])
    (folder / "junk.json").write_bytes(bytes(range(256)) * 10)
    (folder / "junk.py").write_bytes(bytes(range(256)) * 10)
    (folder / "deep.json").write_bytes(b"[" * 10**6)
    (folder / "folder.json").mkdir()
    (folder / "device.json").symlink_to("/dev/zero")
    with (folder / "large.json").open("wb") as stream:
        stream.truncate(2**40)
    return folder


@pytest.mark.parametrize(
    ("name", "code", "message"),
    [
        ("missing.json", "document/file", "No such file or directory"),
        ("folder.json", "document/file", "it is a folder"),
        ("device.json", "document/file", "it is a pipe or a device"),
        ("large.json", "document/size", "at most 67108864 are read"),
        ("truncated.json", "document/json", "the file is not JSON"),
        ("junk.json", "document/json", "the file is not text in UTF-8"),
        ("deep.json", "document/limit", "more than 32 lists and objects in each other"),
        ("junk.py", "command/import", "cannot be imported"),
    ],
)
def test_strange_files_are_refused_by_every_command(strange: Path, name: str, code: str, message: str):
    scenario = f"{strange / name}:f" if name.endswith(".py") else strange / name
    for arguments in (
        ("check", strange / name),
        ("show", strange / name),
        ("run", strange / name),
        ("run", strange / "whole.json", "--scenario", scenario),
    ):
        done = invoke(*arguments)
        assert isinstance(done.exception, SystemExit), done.exception
        assert done.exit_code in (1, 2)
        assert f"error[{code}]: " in done.stderr
        assert message in done.stderr
        assert name in done.stderr
        assert "\n  help: " in done.stderr
        assert not set(map(chr, range(32))) & set(done.stderr) - {"\n"}


def test_no_document_writes_to_the_screen_what_is_no_text(strange: Path):
    whole = (strange / "whole.json").read_bytes()
    (strange / "screen.json").write_bytes(whole.replace(b'"QuarterCar"', rb'"\u001b[2J"'))
    printed = fail(2, "show", strange / "screen.json")
    assert r"the text '\x1b[2J' has control characters" in printed
    assert "\x1b" not in printed
