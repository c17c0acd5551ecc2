"""The order in which the unknowns of sparse linear equations are eliminated."""

from __future__ import annotations

import heapq
from collections.abc import Iterable


def elimination_order(size: int, entries: Iterable[tuple[int, int]]) -> list[int]:
    """An order of the pivots on the diagonal that makes few new entries; `entries` are rows and columns.

    Markowitz' rule, by structure alone: the next pivot is the one with the smallest product of the other entries in its
    row and in its column, of equals the first. The diagonal counts as full.
    """
    columns: list[set[int]] = [set() for _ in range(size)]  # of each row that is left
    rows: list[set[int]] = [set() for _ in range(size)]  # of each column
    for row, column in entries:
        if row != column:
            columns[row].add(column)
            rows[column].add(row)
    heap = [(len(columns[k]) * len(rows[k]), k) for k in range(size)]
    heapq.heapify(heap)
    is_left = [True] * size
    order: list[int] = []
    while heap:
        products, pivot = heapq.heappop(heap)
        if not is_left[pivot] or products != len(columns[pivot]) * len(rows[pivot]):
            continue
        is_left[pivot] = False
        order.append(pivot)
        across, down = columns[pivot], rows[pivot]
        for row in down:
            columns[row] |= across
            columns[row] -= {row, pivot}
        for column in across:
            rows[column] |= down
            rows[column] -= {column, pivot}
        for other in sorted(across | down):
            heapq.heappush(heap, (len(columns[other]) * len(rows[other]), other))
    return order
