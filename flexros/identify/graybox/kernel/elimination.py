"""Order and structure of the elimination of a sparse symmetric matrix, found once before code is written for it.

Right-hand sides are eliminated like further rows of the matrix. Order by greedy least work (Markowitz 1957; Duff,
Erisman and Reid 2017, section 7.2), with the work of the right-hand sides counted.
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
        below: For each pivot, the later pivots (numbers up to n - 1) and right-hand sides (n + number) whose entry in
            its column is not zero, ascending.
        products: Complex products of factorisation and solution.
    """

    order: tuple[int, ...]
    below: tuple[tuple[int, ...], ...]
    products: int


def eliminate(n: int, entries: Iterable[tuple[int, int]], places: Sequence[int]) -> Elimination:
    """Choose the order and find the fill-in.

    Args:
        n: Number of unknowns.
        entries: Places (row, column) that are not zero; one of each symmetric pair is enough.
        places: Place of the only entry, 1, of each right-hand side.

    Returns:
        The structure.
    """
    neighbours: list[set[int]] = [set() for _ in range(n)]
    for row, column in entries:
        if row != column:
            neighbours[row].add(column)
            neighbours[column].add(row)
    sides: list[set[int]] = [set() for _ in range(n)]
    for number, place in enumerate(places):
        sides[place].add(number)

    def work(pivot: int) -> int:
        degree = len(neighbours[pivot])
        return degree * (degree + 1) // 2 + degree * (len(sides[pivot]) + len(places))

    order: list[int] = []
    columns: list[tuple[set[int], set[int]]] = []
    products = 0
    left = set(range(n))
    while left:
        pivot = min(left, key=lambda place: (work(place), place))
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
