"""LLVM text that solves A(jw) Z = B for eight frequencies at once (A complex symmetric, sparse, unrolled).

Factorisation A = L D L^T without exchange of rows, column by column in tiles of two by two that stay in registers:
U = L D is stored, rows of -L are formed when their column comes. Right-hand sides are further rows of U. Pivots
that are small beside the terms they come from are counted, because then rows would have to be exchanged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.compile.ir_text import IrBlock
from flexros.identify.graybox.complex_block import ComplexBlock, ComplexValue
from flexros.identify.graybox.kernel_structure import LANES
from flexros.identify.graybox.sampled import ORDERS

if TYPE_CHECKING:
    from flexros.identify.graybox.kernel_structure import KernelStructure

SMALLEST_PIVOT = 1e-7
"""Smallest pivot beside |K_kk| + w^2 |M_kk| + w |D_kk|: what is lost stays below 1e-9."""


def solution_text(structure: KernelStructure, symbol: str) -> str:
    """Write `void @symbol(ptr matrices, ptr hold, ptr expansion, ptr response, ptr vectors, ptr small)`.

    It reads the packed matrices and expansion of a position and the hold of a block, writes the sampled response
    (complex, one per pair), v of each rank-one vector (complex, (J, M)) and adds the number of small pivots.

    Args:
        structure: Structure of the model.
        symbol: Name of the function.
    """
    writer = _SolutionWriter(structure)
    writer.factorise()
    writer.back_substitute()
    writer.finish()
    arguments = ", ".join(f"ptr noalias %{name}" for name in ("matrices", "hold", "expansion", "response", "vectors"))
    return (
        f"define internal void @{symbol}({arguments}, ptr noalias %small) nounwind {{\nentry:\n"
        f"{writer.block.text()}\n  ret void\n}}"
    )


class _SolutionWriter:
    """Writes the parts in turn; slots are places in complex arrays on the stack."""

    def __init__(self, structure: KernelStructure) -> None:
        self.structure, self.elimination = structure, structure.elimination
        self.block = IrBlock(LANES)
        self.complex = ComplexBlock(self.block)
        self._turn = {place: number for number, place in enumerate(self.elimination.order)}
        self._given = {self._ordered(*entry): number for number, entry in enumerate(structure.entries)}
        self._damped = {self._ordered(*entry) for entry in structure.damped}
        n = structure.n
        filled = [(row, column) for column, rows in enumerate(self.elimination.below) for row in rows]
        self._slots = {place: number for number, place in enumerate(filled)}
        motors = len(structure.places)
        self._U = self._array(len(filled))
        self._inverse = self._array(n)  # of the pivots
        self._rows = self._array(2 * n)  # -L of the two columns at work
        self._Z = self._array(n * motors)
        self._omega = self.block.load("%hold", 0)
        self._minus_square = self._minus(self.block.mul(self._omega, self._omega))
        self._small = self.block.load("%small", 0)

    def _array(self, size: int) -> str:
        return self.block.value(f"alloca {self.block.type}, i64 {2 * max(size, 1)}, align 64")

    def _minus(self, number: str) -> str:
        return self.block.value(f"fneg {self.block.type} {number}")

    def _ordered(self, row: int, column: int) -> tuple[int, int]:
        a, b = self._turn[row], self._turn[column]
        return (a, b) if a >= b else (b, a)

    def factorise(self) -> None:
        """Write the factorisation, right-hand sides included, two columns at a time."""
        n = self.structure.n
        for first in range(0, n, 2):
            columns = [column for column in (first, first + 1) if column < n]
            known = {
                (column, k): self._scaled_row(column, k, side)
                for side, column in enumerate(columns)
                for k in range(first)
                if (column, k) in self._slots
            }
            between = self._pivot_tile(columns, known)
            rows = sorted({row for column in columns for row in self.elimination.below[column]} - set(columns))
            for start in range(0, len(rows), 2):
                self._tile(rows[start : start + 2], columns, known, between)
            label = f"column{first}"  # short blocks compile faster
            self.block.emit(f"br label %{label}")
            self.block.emit(f"{label}:")
        self.block.store(self._small, "%small", 0)

    def _scaled_row(self, column: int, k: int, side: int) -> int:
        """Write -L of one place; return its slot among the rows."""
        U = self.complex.load(self._U, self._slots[column, k])
        slot = side * self.structure.n + k
        scaled = self.complex.mul(U, self.complex.load(self._inverse, k))
        self.complex.store(self.complex.negative(scaled), self._rows, slot)
        return slot

    def _entry(self, row: int, column: int) -> ComplexValue:
        """Write an entry of A, or of the right-hand sides."""
        zero = self.block.number(0.0)
        n = self.structure.n
        if row >= n:
            mine = self.elimination.order[column] == self.structure.places[row - n]
            return ComplexValue(self.block.number(1.0 if mine else 0.0), zero)
        if (row, column) not in self._given:
            return ComplexValue(zero, zero)
        K, M, D = (self._matrix(row, column, part) for part in range(3))
        re = self.block.fma(self._minus_square, M, K)
        return ComplexValue(re, self.block.mul(self._omega, D) if (row, column) in self._damped else zero)

    def _matrix(self, row: int, column: int, part: int) -> str:
        one = self.block.of_lanes(1).load("%matrices", 3 * self._given[row, column] + part)
        return self.block.splat(one)

    def _sums(
        self, rows: list[int], columns: list[int], known: dict[tuple[int, int], int]
    ) -> dict[tuple[int, int], ComplexValue]:
        """Write A - U L^T over the columns before, for the places of a tile that are not zero."""
        places = [(i, j) for i in rows for j in columns if i >= j and (i == j or (i, j) in self._slots)]
        totals = {place: self._entry(*place) for place in places}
        for k in range(columns[0]):
            scaled = {j: self.complex.load(self._rows, known[j, k]) for j in columns if (j, k) in known}
            if not scaled:
                continue
            U = {i: self.complex.load(self._U, self._slots[i, k]) for i in rows if (i, k) in self._slots}
            for i, j in places:
                if i in U and j in scaled:
                    totals[i, j] = self.complex.add_product(totals[i, j], U[i], scaled[j])
        return totals

    def _pivot_tile(self, columns: list[int], known: dict[tuple[int, int], int]) -> ComplexValue | None:
        """Write the pivots of the columns; return -L between them where it is not zero."""
        totals = self._sums(columns, columns, known)
        first = columns[0]
        inverse = self._pivot(first, totals[first, first])
        if len(columns) == 1:
            return None
        second = columns[1]
        between = None
        if (second, first) in totals:
            U = totals[second, first]
            self.complex.store(U, self._U, self._slots[second, first])
            between = self.complex.negative(self.complex.mul(U, inverse))
            totals[second, second] = self.complex.add_product(totals[second, second], U, between)
        self._pivot(second, totals[second, second])
        return between

    def _pivot(self, column: int, pivot: ComplexValue) -> ComplexValue:
        """Write the inverse of a pivot and the check of its size."""
        block = self.block
        K, M, D = (block.intrinsic("fabs", self._matrix(column, column, part)) for part in range(3))
        size = block.fma(self._omega, D, block.fma(block.mul(self._omega, self._omega), M, K))
        limit = block.mul(size, block.number(SMALLEST_PIVOT))
        small = block.compare("ult", self.complex.square(pivot), block.mul(limit, limit))  # also where it is NaN
        one = block.select(small, block.number(1.0), block.number(0.0))
        self._small = block.add(self._small, one)
        inverse = self.complex.inverse(pivot)
        self.complex.store(inverse, self._inverse, column)
        return inverse

    def _tile(
        self, rows: list[int], columns: list[int], known: dict[tuple[int, int], int], between: ComplexValue | None
    ) -> None:
        """Write two rows of U in the columns at work."""
        totals = self._sums(rows, columns, known)
        for (row, column), total in totals.items():
            if column != columns[0] and between is not None and (row, columns[0]) in totals:
                total = self.complex.add_product(total, totals[row, columns[0]], between)
            self.complex.store(total, self._U, self._slots[row, column])

    def back_substitute(self) -> None:
        """Write Z, row by row from the last pivot to the first."""
        n, motors = self.structure.n, len(self.structure.places)
        zero = ComplexValue(self.block.number(0.0), self.block.number(0.0))
        for pivot in reversed(range(n)):
            below = [row for row in self.elimination.below[pivot] if row < n]
            totals = [
                self.complex.load(self._U, self._slots[n + m, pivot]) if (n + m, pivot) in self._slots else zero
                for m in range(motors)
            ]
            for row in below:
                minus_U = self.complex.negative(self.complex.load(self._U, self._slots[row, pivot]))
                for m in range(motors):
                    z = self.complex.load(self._Z, row * motors + m)
                    totals[m] = self.complex.add_product(totals[m], minus_U, z)
            inverse = self.complex.load(self._inverse, pivot)
            for m in range(motors):
                self.complex.store(self.complex.mul(totals[m], inverse), self._Z, pivot * motors + m)
        self.block.emit("br label %solved")
        self.block.emit("solved:")

    def finish(self) -> None:
        """Write the sampled responses and the rank-one vectors v = Z^T b."""
        motors, places = len(self.structure.places), self.structure.places
        gain = ComplexValue(self.block.load("%hold", 1), self.block.load("%hold", 2))
        scalar = self.block.of_lanes(1)
        for number, (m, n) in enumerate(self.structure.pairs):
            total = self.complex.mul(gain, self.complex.load(self._Z, self._turn[places[m]] * motors + n))
            for order in range(len(ORDERS)):
                alias = ComplexValue(self.block.load("%hold", 3 + 2 * order), self.block.load("%hold", 4 + 2 * order))
                factor = self.block.splat(scalar.load("%expansion", order * len(self.structure.pairs) + number))
                total = self.complex.add_scaled(total, alias, factor)
            self.complex.store(total, "%response", number)
        for number, vector in enumerate(self.structure.vectors):
            for m in range(motors):
                parts = [
                    self.complex.scaled(self._unknown(place, m), self.block.number(coefficient))
                    for place, coefficient in vector
                ]
                total = parts[0]
                for part in parts[1:]:
                    total = self.complex.add(total, part)
                self.complex.store(total, "%vectors", number * motors + m)

    def _unknown(self, place: int, m: int) -> ComplexValue:
        return self.complex.load(self._Z, self._turn[place] * len(self.structure.places) + m)
