"""Entries survive processes, and nothing comes back that was not put there under the same key."""

from __future__ import annotations

import errno
import logging
import os
import subprocess
import sys
import time
from pathlib import Path

import platformdirs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from propermodel.codegen import object_cache
from propermodel.codegen.object_cache import ObjectCache, Usage, user_cache

KEY, OTHER = "ab" * 32, "cd" * 32


@pytest.fixture
def cache(tmp_path: Path) -> ObjectCache:
    return ObjectCache(tmp_path / "cache")


def entry(cache: ObjectCache, key: str = KEY) -> Path:
    return cache.folder / f"{key}.entry"


def test_what_was_put_comes_back(cache: ObjectCache):
    assert cache.get(KEY) is None
    cache.put(KEY, b"first")
    cache.put(OTHER, b"")
    cache.put(KEY, b"second")
    assert (cache.get(KEY), cache.get(OTHER)) == (b"second", b"")
    assert cache.usage().entries == 2


def test_only_what_the_cache_has_written_is_cleared(cache: ObjectCache):
    cache.put(KEY, b"code")
    (cache.folder / "notes.txt").write_text("mine")
    size = entry(cache).stat().st_size
    assert cache.clear() == Usage(1, size)
    assert [path.name for path in cache.folder.iterdir()] == ["notes.txt"]
    assert cache.clear() == Usage(0, 0)


# -- damage ---------------------------------------------------------------------------------------------


@given(st.binary(max_size=40), st.data())
def test_damage_is_seen_wherever_it_is(tmp_path_factory: pytest.TempPathFactory, content: bytes, data: st.DataObject):
    cache = ObjectCache(tmp_path_factory.mktemp("cache"))
    cache.put(KEY, content)
    whole = entry(cache).read_bytes()
    place = data.draw(st.integers(0, len(whole) - 1))
    flipped = whole[:place] + bytes([whole[place] ^ data.draw(st.integers(1, 255))]) + whole[place + 1 :]
    for damaged in (flipped, whole[:place], whole + b"\0"):
        entry(cache).write_bytes(damaged)
        assert cache.get(KEY) is None
        assert not entry(cache).exists()  # to be made anew


def test_an_entry_under_another_key_is_refused(cache: ObjectCache):
    cache.put(KEY, b"code")
    entry(cache).rename(entry(cache, OTHER))
    assert cache.get(OTHER) is None


@pytest.mark.skipif(os.name != "posix", reason="rights of other users are told by modes on POSIX systems only")
def test_a_folder_that_others_may_write_into_is_not_used(cache: ObjectCache, caplog: pytest.LogCaptureFixture):
    cache.put(KEY, b"code")
    cache.folder.chmod(0o777)
    assert cache.get(KEY) is None
    cache.put(OTHER, b"code")
    assert not entry(cache, OTHER).exists()
    assert caplog.text.count("others own it or may write into it") == 1
    cache.folder.chmod(0o755)
    assert cache.get(KEY) == b"code"


# -- what the disk refuses ------------------------------------------------------------------------------


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS, errno.EACCES])
def test_a_disk_that_refuses_costs_one_note(
    cache: ObjectCache, code: int, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
):
    def refuse(path: Path, content: bytes) -> int:
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(Path, "write_bytes", refuse)
    with caplog.at_level(logging.WARNING):
        cache.put(KEY, b"code" * 100)
        cache.put(OTHER, b"code" * 100)
    assert list(cache.folder.iterdir()) == []
    (record,) = caplog.records
    assert record.message == (
        f"compiled code is not kept in {cache.folder}: {os.strerror(code)}; "
        "PROPERMODEL_CACHE names another folder, or is off"
    )
    monkeypatch.undo()
    cache.put(KEY, b"code")
    assert cache.get(KEY) == b"code"


FILLED = """
import resource, signal, sys
from pathlib import Path
from propermodel.codegen.object_cache import ObjectCache
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
cache = ObjectCache(Path(sys.argv[1]))
cache.put("ab" * 32, b"x" * 100_000)
cache.put("cd" * 32, b"y" * 1000)
print(cache.get("ab" * 32), len(cache.get("cd" * 32)))
"""


@pytest.mark.skipif(os.name != "posix", reason="limits of file sizes exist on POSIX systems only")
def test_a_write_that_ends_half_way_leaves_nothing(tmp_path: Path):
    done = subprocess.run([sys.executable, "-c", FILLED, str(tmp_path)], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["None", "1000"]
    assert done.stderr.startswith("compiled code is not kept")
    assert len(done.stderr.splitlines()) == 1
    assert [path.suffix for path in tmp_path.iterdir()] == [".entry"]


def test_a_file_in_place_of_the_folder_costs_one_note(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    (tmp_path / "file").write_text("mine")
    cache = ObjectCache(tmp_path / "file" / "cache")
    assert cache.get(KEY) is None
    cache.put(KEY, b"code")
    assert cache.get(KEY) is None
    assert len(caplog.records) == 1
    assert (tmp_path / "file").read_text() == "mine"


# -- room -----------------------------------------------------------------------------------------------


def test_the_least_recently_used_go_first(tmp_path: Path):
    keys = [f"{k:064x}" for k in range(6)]
    cache = ObjectCache(tmp_path, most_bytes=3 * 1100)
    for age, key in enumerate(keys[:3]):
        cache.put(key, b"x" * 1000)
        long_ago = time.time() - 1000.0 + 10.0 * age
        os.utime(entry(cache, key), (long_ago, long_ago))
    assert cache.get(keys[0]) is not None  # used: now the youngest
    cache.put(keys[3], b"x" * 1000)
    assert [cache.get(key) is not None for key in keys[:4]] == [True, False, True, True]
    assert cache.usage().size <= cache.most_bytes


def test_what_a_dead_writer_has_left_is_removed(cache: ObjectCache):
    cache.put(KEY, b"code")
    dead, alive = cache.folder / "dead.unfinished", cache.folder / "alive.unfinished"
    for path in (dead, alive):
        path.write_bytes(b"half")
    long_ago = time.time() - 7200.0
    os.utime(dead, (long_ago, long_ago))
    cache.put(OTHER, b"code")
    assert (dead.exists(), alive.exists()) == (False, True)
    assert cache.get(KEY) == b"code"


WRITER = """
import sys
from pathlib import Path
from propermodel.codegen.object_cache import ObjectCache
cache = ObjectCache(Path(sys.argv[1]), most_bytes=120_000)
letter = sys.argv[2].encode()
for turn in range(150):
    key = f"{turn % 4:064x}"
    cache.put(key, letter * (20_000 + turn))
    found = cache.get(key)
    assert found is None or found == found[:1] * len(found), "a mixture"
"""


def test_processes_may_write_the_same_at_once(tmp_path: Path):
    writers = [
        subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path), letter], stderr=subprocess.PIPE, text=True)
        for letter in "ab"
    ]
    errors = [writer.communicate()[1] for writer in writers]
    assert errors == ["", ""]
    cache = ObjectCache(tmp_path)
    contents = [cache.get(f"{turn:064x}") for turn in range(4)]
    assert all(content and content == content[:1] * len(content) for content in contents)
    assert [path for path in tmp_path.iterdir() if path.suffix == ".unfinished"] == []


# -- where ----------------------------------------------------------------------------------------------


def test_the_environment_moves_it_and_switches_it_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PROPERMODEL_CACHE", str(tmp_path))
    moved = user_cache()
    assert moved is not None
    assert moved.folder == tmp_path
    for off in ("off", "OFF"):
        monkeypatch.setenv("PROPERMODEL_CACHE", off)
        assert user_cache() is None


def test_it_is_where_the_system_wants_it(monkeypatch: pytest.MonkeyPatch):
    for unset in (lambda: monkeypatch.delenv("PROPERMODEL_CACHE"), lambda: monkeypatch.setenv("PROPERMODEL_CACHE", "")):
        unset()
        found = user_cache()
        assert found is not None
        assert found.folder == Path(platformdirs.user_cache_dir("propermodel", appauthor=False))


@pytest.fixture(autouse=True)
def _nothing_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(object_cache, "_noted", set())
