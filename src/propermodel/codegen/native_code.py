"""The machine code of a program: from the cache of the user where it is there, otherwise printed, compiled and kept."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING

from propermodel.codegen.arrangement import Arrangement, Printing
from propermodel.codegen.fingerprint import fingerprint
from propermodel.codegen.llvm_compiler import Effort, compile_text, host
from propermodel.codegen.machine import Method
from propermodel.codegen.object_cache import user_cache
from propermodel.codegen.program import Program

if TYPE_CHECKING:
    from propermodel.codegen.print_program import Source

# What decides which text a program is printed as: every file of these rooms is part of the key.
_ROOMS = ("propermodel.codegen", "propermodel.expressions")


@dataclass(frozen=True)
class NativeCode:
    """Object code, and where its numbers are."""

    code: bytes
    arrangement: Arrangement
    effort: Effort

    def to_bytes(self) -> bytes:
        """The form in which it is kept."""
        head = json.dumps(self.arrangement.to_json()).encode()
        return b"".join((len(head).to_bytes(8, "little"), head, self.code))

    @staticmethod
    def from_bytes(content: bytes, effort: Effort) -> NativeCode:
        """What `to_bytes` has written."""
        end = 8 + int.from_bytes(content[:8], "little")
        return NativeCode(content[end:], Arrangement.from_json(json.loads(content[8:end])), effort)


@dataclass(frozen=True, eq=False)
class Recipe:
    """What is to be compiled: a program, for a method and a number of lanes, printed in some way."""

    program: Program
    method: Method
    lanes: int
    printing: Printing

    def cached(self, effort: Effort) -> NativeCode | None:
        """The code, where an earlier process of this user has made the same for the same machine."""
        cache = user_cache()
        content = None if cache is None else cache.get(self._key(effort))
        return None if content is None else NativeCode.from_bytes(content, effort)

    def get(self, effort: Effort) -> NativeCode:
        """The code, made now where nobody has made it before."""
        return self.cached(effort) or self.make(effort)

    def make(self, effort: Effort) -> NativeCode:
        """The code, made now and kept for later processes."""
        source = self._source
        made = NativeCode(compile_text(source.text, effort), source.arrangement, effort)
        cache = user_cache()
        if cache is not None:
            cache.put(self._key(effort), made.to_bytes())
        return made

    @cached_property
    def _source(self) -> Source:
        # Where an earlier process has kept the code, nothing is printed.
        from propermodel.codegen.print_program import print_program

        return print_program(self.program, self.method, self.lanes, self.printing)

    @cached_property
    def _digest(self) -> str:
        what = (fingerprint((self.program, self.printing)), self.method.value, str(self.lanes))
        return hashlib.sha256("\n".join((*what, *host(), generator_digest())).encode()).hexdigest()

    def _key(self, effort: Effort) -> str:
        return hashlib.sha256(f"{self._digest} {effort.value}".encode()).hexdigest()


@lru_cache(maxsize=1)
def generator_digest() -> str:
    """A digest of what prints and compiles programs, so that no change of it meets code made before."""
    digest = hashlib.sha256()
    for room in _ROOMS:
        sources = (file for file in files(room).iterdir() if file.is_file())
        for source in sorted(sources, key=lambda file: file.name):
            content = source.read_bytes()
            digest.update(f"{room} {source.name} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()
