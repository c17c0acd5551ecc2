"""Machine code from the cache is the code that was made for the same program, machine and compiler."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propermodel.codegen import native_code, print_program
from propermodel.codegen.arrangement import PRINTING, Printing
from propermodel.codegen.llvm_compiler import Effort, host
from propermodel.codegen.machine import Method, Request
from propermodel.codegen.native import NativeMachine
from propermodel.codegen.native_code import NativeCode, Recipe, generator_digest
from propermodel.codegen.object_cache import user_cache
from tests.codegen.programs import Draft, chain, oscillator


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("PROPERMODEL_CACHE", str(folder))
    return folder


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[Effort]:
    """What LLVM is asked to compile from now on."""
    asked: list[Effort] = []
    compile_text = native_code.compile_text

    def counted(text: str, effort: Effort) -> bytes:
        asked.append(effort)
        return compile_text(text, effort)

    monkeypatch.setattr(native_code, "compile_text", counted)
    return asked


def entries(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.entry"))


def final(draft: Draft, machine: NativeMachine, until: float = 0.2) -> list[np.ndarray]:
    memory = draft.memory(machine.lanes)
    outcome = machine.run(memory, Request(until=until, step=1e-3, row_period=0.01, selected=np.arange(1)))
    return [memory.state, memory.activity, memory.discrete, outcome.rows, outcome.row_times]


@pytest.mark.parametrize("lanes", [1, 4])
@pytest.mark.parametrize("make", [oscillator, lambda: chain(5)], ids=["oscillator", "chain"])
def test_a_hit_gives_the_same_bits(make, lanes: int, folder: Path, compiled: list[Effort], monkeypatch):
    draft = make()
    first = final(draft, NativeMachine(draft.program(), Method.SEMI_IMPLICIT, lanes))
    again = final(draft, NativeMachine(make().program(), Method.SEMI_IMPLICIT, lanes))
    assert compiled == [Effort.QUICK]
    assert len(entries(folder)) == 1
    monkeypatch.setenv("PROPERMODEL_CACHE", "off")
    without = final(draft, NativeMachine(draft.program(), Method.SEMI_IMPLICIT, lanes))
    assert len(compiled) == 2
    for a, b, c in zip(first, again, without, strict=True):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(a, c)


def test_a_hit_prints_nothing(monkeypatch: pytest.MonkeyPatch):
    program = chain(3).program()
    NativeMachine(program, Method.RK4)

    def printed(*_: object) -> None:
        raise AssertionError("printed")

    monkeypatch.setattr(print_program, "print_program", printed)
    assert NativeMachine(program, Method.RK4).effort is Effort.QUICK
    with pytest.raises(AssertionError, match="printed"):
        NativeMachine(program, Method.EULER)


def test_thorough_code_that_is_there_is_taken_at_once(compiled: list[Effort]):
    draft = chain(3)
    long = NativeMachine(draft.program(), Method.EULER, long_run=10)
    expected = final(draft, long)
    machine = NativeMachine(draft.program(), Method.EULER, long_run=10)
    assert machine.effort is Effort.THOROUGH
    for a, b in zip(expected, final(draft, machine), strict=True):
        np.testing.assert_array_equal(a, b)
    assert compiled == [Effort.QUICK, Effort.THOROUGH]


def test_everything_that_decides_the_code_is_in_the_key(monkeypatch: pytest.MonkeyPatch):
    program = chain(3).program()

    def key(
        method: Method = Method.EULER, lanes: int = 1, printing: Printing = PRINTING, effort: Effort = Effort.QUICK
    ) -> str:
        return Recipe(program, method, lanes, printing)._key(effort)

    assert key() == key()
    keys = {key(), key(method=Method.RK4), key(lanes=2), key(effort=Effort.THOROUGH)}
    keys |= {key(printing=Printing(most_instructions=7)), key(printing=Printing(loops_from=7))}
    machine = host()
    for part in range(len(machine)):
        changed = (*machine[:part], machine[part] + "x", *machine[part + 1 :])
        monkeypatch.setattr(native_code, "host", lambda changed=changed: changed)
        keys.add(key())
    monkeypatch.setattr(native_code, "host", lambda: machine)
    monkeypatch.setattr(native_code, "generator_digest", lambda: "another version")
    keys.add(key())
    assert len(keys) == 6 + len(machine) + 1
    assert len(machine) == 5  # processor, its features, system, llvmlite, LLVM
    assert all(machine)


def test_the_key_changes_with_the_sources_of_the_generator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    found = generator_digest()
    copies = {}
    for room in native_code._ROOMS:
        copies[room] = tmp_path / room
        copies[room].mkdir()
        for source in Path(native_code.__file__).parents[1].joinpath(room.split(".")[1]).glob("*"):
            if source.is_file():
                (copies[room] / source.name).write_bytes(source.read_bytes())
    monkeypatch.setattr(native_code, "files", copies.__getitem__)
    digest = generator_digest.__wrapped__
    assert digest() == found
    for name in ("llvm_math.py", "print_program.py", "repeats.py", "llvm_compiler.py"):
        source = copies["propermodel.codegen"] / name
        before = source.read_bytes()
        source.write_bytes(before + b"#")
        assert digest() != found
        source.write_bytes(before)
    assert digest() == found
    (copies["propermodel.expressions"] / "new.py").write_text("")
    assert digest() != found


@pytest.mark.parametrize(
    "damage", [lambda old: old[: len(old) // 2], lambda old: old[:-1] + b"\xff\xfe", lambda _: b""]
)
def test_damaged_code_is_made_anew(damage, folder: Path, compiled: list[Effort]):
    draft = chain(3)
    expected = final(draft, NativeMachine(draft.program(), Method.EULER))
    (path,) = entries(folder)
    path.write_bytes(damage(path.read_bytes()))
    for _ in range(2):
        for a, b in zip(expected, final(draft, NativeMachine(draft.program(), Method.EULER)), strict=True):
            np.testing.assert_array_equal(a, b)
    assert compiled == [Effort.QUICK] * 2


def test_code_of_another_program_is_never_taken(folder: Path, compiled: list[Effort]):
    NativeMachine(chain(3).program(), Method.EULER)
    NativeMachine(chain(4).program(), Method.EULER)
    one, other = entries(folder)
    one.write_bytes(other.read_bytes())
    draft = chain(3), chain(4)
    for each in draft:
        final(each, NativeMachine(each.program(), Method.EULER))
    assert len(compiled) == 3


def test_without_a_usable_folder_everything_is_compiled(tmp_path: Path, monkeypatch, compiled: list[Effort], caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("PROPERMODEL_CACHE", str(tmp_path / "file" / "cache"))
    draft = chain(3)
    for _ in range(2):
        final(draft, NativeMachine(draft.program(), Method.EULER))
    assert compiled == [Effort.QUICK] * 2
    assert len(caplog.records) == 1


def test_switched_off_it_leaves_no_trace(folder: Path, monkeypatch: pytest.MonkeyPatch, compiled: list[Effort]):
    monkeypatch.setenv("PROPERMODEL_CACHE", "off")
    for _ in range(2):
        NativeMachine(chain(3).program(), Method.EULER)
    assert len(compiled) == 2
    assert user_cache() is None
    assert not folder.exists()


def test_what_is_kept_is_read_back():
    made = Recipe(oscillator().program(), Method.EULER, 2, PRINTING).make(Effort.QUICK)
    read = NativeCode.from_bytes(made.to_bytes(), Effort.QUICK)
    assert read.code == made.code
    assert read.arrangement.to_json() == made.arrangement.to_json()
