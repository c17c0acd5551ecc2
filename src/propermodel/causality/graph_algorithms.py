"""Two algorithms on graphs of numbered nodes: strong components, and a partner for each.

They are short enough to stand here, and spare every start of a program the loading of a library of sparse matrices.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence


def strong_components(count: int, edges: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Strongly connected components of a directed graph, those that others depend on first; members in order.

    An edge (i, j) says that i depends on j. R. Tarjan, Depth-first search and linear graph algorithms, 1972.
    """
    needs: list[list[int]] = [[] for _ in range(count)]
    for i, j in sorted(set(edges), reverse=True):
        needs[i].append(j)
    found: list[list[int]] = []
    met: dict[int, int] = {}  # when a node was met first
    oldest: dict[int, int] = {}  # when the first met of the open nodes that a node reaches was met
    is_open = [False] * count  # met, component not yet known
    open_nodes: list[int] = []
    way: list[tuple[int, Iterator[int]]] = []  # to the present node, with the edges not yet followed

    def enter(node: int) -> None:
        met[node] = oldest[node] = len(met)
        is_open[node] = True
        open_nodes.append(node)
        way.append((node, iter(needs[node])))

    def leave(node: int) -> None:
        way.pop()
        if way:
            before = way[-1][0]
            oldest[before] = min(oldest[before], oldest[node])
        if oldest[node] == met[node]:
            component: list[int] = []
            while not component or component[-1] != node:
                component.append(open_nodes.pop())
                is_open[component[-1]] = False
            found.append(sorted(component))

    for start in range(count):
        if start not in met:
            enter(start)
        while way:
            node, edges_left = way[-1]
            for other in edges_left:
                if other not in met:
                    enter(other)
                    break
                if is_open[other]:
                    oldest[node] = min(oldest[node], met[other])
            else:
                leave(node)
    return found


def match_each(candidates: Sequence[Sequence[int]]) -> list[int] | None:
    """For every entry a candidate of its own; None where there are not enough. By shortest augmenting paths."""
    chosen: list[int] = [-1] * len(candidates)
    owner: dict[int, int] = {}
    for entry in range(len(candidates)):
        asked_by: dict[int, int] = {}
        asking, free = [entry], None
        for asker in asking:  # grows by the owners of what is asked for
            new = [candidate for candidate in candidates[asker] if candidate not in asked_by]
            asked_by.update(dict.fromkeys(new, asker))
            free = next((candidate for candidate in new if candidate not in owner), None)
            if free is not None:
                break
            asking.extend(owner[candidate] for candidate in new)
        while free is not None:
            asker = asked_by[free]
            given_up = chosen[asker]
            chosen[asker], owner[free] = free, asker
            free = given_up if asker != entry else None
        if chosen[entry] < 0:
            return None
    return chosen
