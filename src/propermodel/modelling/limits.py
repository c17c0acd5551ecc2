"""What is read of a file at most, so that a file from a stranger costs little time and memory.

What goes beyond is refused before it is understood. The limits stand far above what honest files hold.
"""

from __future__ import annotations

from dataclasses import dataclass

from propermodel.diagnostics import DocumentError


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """The most that is read of a file; give greater ones for a file that you trust, `Limits(parts=1_000_000)`.

    Attributes:
        file_bytes: Bytes of a JSON document or a CSV file.
        trajectory_bytes: Bytes that the packed parts of a trajectory unpack to.
        trajectory_parts: Parts of a trajectory: arrays, and reports on how far it had come.
        values: Values of a JSON document: numbers, texts, lists, objects.
        depth: Lists and objects of a JSON document, one in another.
        text_characters: Characters of a text, or of a path written with dots.
        name_characters: Characters of one name of a path.
        units: Different units of a document.
        expressions: Nodes of the expressions of a model.
        expression_uses: Nodes that the definitions of a model use, counted once for each definition.
        parts: Parts of a model, counted for each use of a definition.
        path_names: Names in the paths of all that the parts of a model declare.
        table_points: Values of a table, or rows of a CSV file.
    """

    file_bytes: int = 64 * 2**20
    trajectory_bytes: int = 2 * 2**30
    trajectory_parts: int = 200_000
    values: int = 4_000_000
    depth: int = 32
    text_characters: int = 100_000
    name_characters: int = 1000
    units: int = 1000
    expressions: int = 1_000_000
    expression_uses: int = 5_000_000
    parts: int = 100_000
    path_names: int = 10_000_000
    table_points: int = 2_000_000


LIMITS = Limits()


def exceeded(limit: str, message: str, where: str = "", code: str = "document/limit") -> DocumentError:
    """The error for what goes beyond the limit of this name."""
    return DocumentError.of(
        code, message, where=where, help=f"if you trust the file, read it with limits=pm.Limits({limit}=...)"
    )
