"""Order and structure of the elimination of a sparse symmetric matrix, computed once before its code is generated.

Right-hand sides are eliminated like further rows of the matrix. Greedy order of least work (Markowitz 1957; Duff,
Erisman and Reid 2017, section 7.2), right-hand sides included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


@dataclass(frozen=True)
class Elimination:
    """Structure of A = L D L^T without exchange of rows, in the order of elimination.

    Attributes:
        order: Coordinate that is eliminated as pivot 0, 1, ..., length n.
        below: For each pivot, the later pivots (indices up to n - 1) and right-hand sides (n + index) whose entry in
            its column is not zero, ascending.
        products: Complex products of factorisation and solution.
    """

    order: tuple[int, ...]
    below: tuple[tuple[int, ...], ...]
    products: int


def eliminate(n: int, entries: Iterable[tuple[int, int]], sources: Sequence[int]) -> Elimination:
    """Choose the order and compute the fill-in.

    Args:
        n: Number of unknowns.
        entries: Non-zero entries (row, column); one of each symmetric pair is enough.
        sources: Row of the only entry, 1, of each right-hand side.
    """
    neighbours: list[set[int]] = [set() for _ in range(n)]
    for row, column in entries:
        if row != column:
            neighbours[row].add(column)
            neighbours[column].add(row)
    sides: list[set[int]] = [set() for _ in range(n)]
    for number, row in enumerate(sources):
        sides[row].add(number)

    def work(pivot: int) -> int:
        degree = len(neighbours[pivot])
        return degree * (degree + 1) // 2 + degree * (len(sides[pivot]) + len(sources))

    order: list[int] = []
    columns: list[tuple[set[int], set[int]]] = []
    products = 0
    left = set(range(n))
    while left:
        pivot = min(left, key=lambda row: (work(row), row))
        products += work(pivot)
        left.remove(pivot)
        order.append(pivot)
        columns.append((set(neighbours[pivot]), set(sides[pivot])))
        for other in neighbours[pivot]:
            neighbours[other] |= neighbours[pivot] - {other}
            neighbours[other].discard(pivot)
            sides[other] |= sides[pivot]
    turn = {pivot: number for number, pivot in enumerate(order)}
    below = tuple(
        (*sorted(turn[other] for other in others), *sorted(n + side for side in right)) for others, right in columns
    )
    return Elimination(tuple(order), below, products)
