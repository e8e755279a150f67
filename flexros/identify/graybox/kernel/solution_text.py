"""LLVM text that solves A(jw) Z = B for eight frequencies at once (A complex symmetric, sparse).

Factorisation A = L D L^T without exchange of rows, a few columns at a time in tiles that stay in registers: U = L D is
stored, rows of -L are formed when their column is due. Right-hand sides are further rows of U. Entries that are never
filled are skipped; a loop covers columns of equal structure. Pivots that are small relative to the terms they are
computed from are counted, because then rows would have to be exchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeAlias

from flexros.compile.ir_text import IrBlock
from flexros.identify.frf.sampled import ORDERS
from flexros.identify.graybox.kernel.complex_block import ComplexBlock, ComplexValue
from flexros.identify.graybox.kernel.slope_text import SlopeWriter
from flexros.identify.graybox.kernel.structure import LANES

if TYPE_CHECKING:
    from flexros.identify.graybox.kernel.structure import KernelStructure

_Body: TypeAlias = Callable[["int | str", list[ComplexValue]], list[ComplexValue]]
"""Writes one turn for a number or an i64 value: totals before, totals after."""
TILE = 3
"""Rows and columns of a tile: nine complex sums and their factors fill 32 vector registers."""
SHORTEST_LOOP = 4
"""Shorter runs of columns are unrolled."""
SMALLEST_PIVOT = 1e-7
"""Smallest pivot relative to |K_kk| + w^2 |M_kk| + w |D_kk|; cancellation stays below 1e-9."""


def solution_text(structure: KernelStructure, symbol: str) -> str:
    """Write `void @symbol(ptr matrices, ptr hold, ptr expansion, ptr response, ptr vectors, ptr small)`.

    It reads the packed matrices and expansion of a position and the hold of a block, writes the sampled response
    (complex, one per pair), v of each rank-one vector and the products of slopes (complex, `factor_numbers`) and adds
    the number of small pivots.

    Args:
        structure: Structure of the model.
        symbol: Name of the function.
    """
    writer = _SolutionWriter(structure)
    writer.factorise()
    writer.back_substitute()
    writer.finish()
    SlopeWriter(structure, writer.block, writer.Z, writer.omega).write()
    arguments = ", ".join(f"ptr noalias %{name}" for name in ("matrices", "hold", "expansion", "response", "vectors"))
    return (
        f"define internal void @{symbol}({arguments}, ptr noalias %small) nounwind {{\nentry:\n"
        f"{writer.block.text()}\n  ret void\n}}"
    )


def _paired(parts: Sequence[str]) -> list[ComplexValue]:
    """Real and imaginary parts in turn as complex values."""
    return [ComplexValue(re, im) for re, im in zip(parts[::2], parts[1::2], strict=True)]


def _runs(numbers: Sequence[int]) -> list[range]:
    """Ascending numbers as ranges without gaps."""
    starts = [number for number in numbers if number - 1 not in numbers]
    stops = [number + 1 for number in numbers if number + 1 not in numbers]
    return [range(start, stop) for start, stop in zip(starts, stops, strict=True)]


class _SolutionWriter:
    """Writes the parts in turn into complex arrays on the stack; rows and columns are indices of pivots."""

    def __init__(self, structure: KernelStructure) -> None:
        self.structure, self.elimination = structure, structure.elimination
        self.block = IrBlock(LANES)
        self.complex = ComplexBlock(self.block)
        self._turn = {coordinate: number for number, coordinate in enumerate(self.elimination.order)}
        self._given = {self._ordered(*entry): number for number, entry in enumerate(structure.entries)}
        self._damped = {self._ordered(*entry) for entry in structure.damped}
        self._filled = {(row, column) for column, rows in enumerate(self.elimination.below) for row in rows}
        n, motors = structure.n, len(structure.motors)
        self._stride = n | 1  # odd, so that a column does not fall on few lines of the cache
        self._U = self._array((n + motors) * self._stride)
        self._inverse = self._array(n)  # of the pivots
        self._rows = self._array(TILE * n)  # -L of the current columns
        self.Z = self._array(n * motors)
        self.omega = self.block.load("%hold", 0)
        self._minus_square = self._minus(self.block.mul(self.omega, self.omega))
        self._small = self.block.load("%small", 0)

    def _array(self, size: int) -> str:
        return self.block.value(f"alloca {self.block.type}, i64 {2 * size}, align 64")

    def _minus(self, number: str) -> str:
        return self.block.value(f"fneg {self.block.type} {number}")

    def _ordered(self, row: int, column: int) -> tuple[int, int]:
        a, b = self._turn[row], self._turn[column]
        return (a, b) if a >= b else (b, a)

    def _at(self, base: str, index: int | str, stride: int = 1) -> str:
        """Write the address of element `index * stride` of a complex array."""
        if isinstance(index, int):
            return self.block.pointer(base, 2 * stride * index)
        return self.block.pointer(base, self.block.value(f"mul nsw i64 {index}, {2 * stride}"))

    def _over(self, numbers: range, totals: list[ComplexValue], body: _Body) -> list[ComplexValue]:
        """Write a body for each number, as a loop from `SHORTEST_LOOP` numbers on; it turns totals into new totals."""
        if len(numbers) < SHORTEST_LOOP:
            for number in numbers:
                totals = body(number, totals)
            return totals
        carry = [(self.block.type, part) for total in totals for part in total]
        with self.block.loop(numbers.start, numbers.stop, carry=carry) as turn:
            following = body(turn.index, _paired(turn.values))
            turn.next_values = [part for total in following for part in total]
        return _paired(turn.values)

    def factorise(self) -> None:
        """Write the factorisation, right-hand sides included, some columns at a time."""
        for first in range(0, self.structure.n, TILE):
            columns = list(range(first, min(first + TILE, self.structure.n)))
            for side, column in enumerate(columns):
                self._scale_row(column, side, first)
            between = self._pivot_tile(columns)
            rows = sorted({row for column in columns for row in self.elimination.below[column]} - set(columns))
            for start in range(0, len(rows), TILE):
                self._tile(rows[start : start + TILE], columns, between)
        self.block.store(self._small, "%small", 0)

    def _scale_row(self, column: int, side: int, first: int) -> None:
        """Write the row of -L of a current column."""

        def body(k: int | str, totals: list[ComplexValue]) -> list[ComplexValue]:
            U = self.complex.load(self._at(self._U, k), column * self._stride)
            scaled = self.complex.mul(U, self.complex.load(self._at(self._inverse, k), 0))
            self.complex.store(self.complex.negative(scaled), self._at(self._rows, k), side * self.structure.n)
            return totals

        for run in _runs([k for k in range(first) if (column, k) in self._filled]):
            self._over(run, [], body)

    def _entry(self, row: int, column: int) -> ComplexValue:
        """Write an entry of A, or of the right-hand sides."""
        zero = self.block.number(0.0)
        n = self.structure.n
        if row >= n:
            drives = self.elimination.order[column] == self.structure.motors[row - n]
            return ComplexValue(self.block.number(1.0 if drives else 0.0), zero)
        if (row, column) not in self._given:
            return ComplexValue(zero, zero)
        K, M, D = (self._matrix(row, column, part) for part in range(3))
        re = self.block.fma(self._minus_square, M, K)
        return ComplexValue(re, self.block.mul(self.omega, D) if (row, column) in self._damped else zero)

    def _matrix(self, row: int, column: int, part: int) -> str:
        return self.block.splat(self.block.of_lanes(1).load("%matrices", 3 * self._given[row, column] + part))

    def _sums(self, rows: list[int], columns: list[int]) -> dict[tuple[int, int], ComplexValue]:
        """Write A - U L^T over the earlier columns, for the non-zero entries of a tile."""
        totals = {(i, j): self._entry(i, j) for i in rows for j in columns if i == j or (i, j) in self._filled}
        first = columns[0]
        patterns = [
            (
                tuple(i for i in rows if (i, k) in self._filled),
                tuple(j for j in columns if (j, k) in self._filled),
            )
            for k in range(first)
        ]
        for pattern in sorted(set(patterns)):
            active = [entry for entry in totals if entry[0] in pattern[0] and entry[1] in pattern[1]]
            for run in _runs([k for k in range(first) if active and patterns[k] == pattern]):
                sums = self._over(run, [totals[entry] for entry in active], self._update(active, columns))
                totals.update(zip(active, sums, strict=True))
        return totals

    def _update(self, entries: list[tuple[int, int]], columns: list[int]) -> _Body:
        """Write what one earlier column subtracts from the entries of a tile."""

        def body(k: int | str, totals: list[ComplexValue]) -> list[ComplexValue]:
            rows, U = self._at(self._rows, k), self._at(self._U, k)
            scaled = {j: self.complex.load(rows, columns.index(j) * self.structure.n) for _, j in entries}
            left = {i: self.complex.load(U, i * self._stride) for i, _ in entries}
            return [
                self.complex.add_product(total, left[i], scaled[j])
                for (i, j), total in zip(entries, totals, strict=True)
            ]

        return body

    def _pivot_tile(self, columns: list[int]) -> dict[tuple[int, int], ComplexValue]:
        """Write the pivots of the columns; return -L between them where it is not zero."""
        totals = self._sums(columns, columns)
        between: dict[tuple[int, int], ComplexValue] = {}
        for column in columns:
            inverse = self._pivot(column, totals[column, column])
            for row in columns:
                if row > column and (row, column) in totals:
                    between[row, column] = self.complex.negative(self.complex.mul(totals[row, column], inverse))
                    self._store(totals[row, column], row, column)
            self._eliminate(column, totals, between)
        return between

    def _eliminate(
        self, column: int, totals: dict[tuple[int, int], ComplexValue], between: dict[tuple[int, int], ComplexValue]
    ) -> None:
        """Write what one column of a tile subtracts from the later ones."""
        for (row, later), total in totals.items():
            if later > column and (row, column) in totals and (later, column) in between:
                product = self.complex.add_product(total, totals[row, column], between[later, column])
                totals[row, later] = product

    def _store(self, number: ComplexValue, row: int, column: int) -> None:
        self.complex.store(number, self._U, row * self._stride + column)

    def _pivot(self, column: int, pivot: ComplexValue) -> ComplexValue:
        """Write the inverse of a pivot and the check of its size."""
        block = self.block
        K, M, D = (block.intrinsic("fabs", self._matrix(column, column, part)) for part in range(3))
        size = block.fma(self.omega, D, block.fma(block.mul(self.omega, self.omega), M, K))
        limit = block.mul(size, block.number(SMALLEST_PIVOT))
        small = block.compare("ult", self.complex.square(pivot), block.mul(limit, limit))  # also where it is NaN
        self._small = block.add(self._small, block.select(small, block.number(1.0), block.number(0.0)))
        inverse = self.complex.inverse(pivot)
        self.complex.store(inverse, self._inverse, column)
        return inverse

    def _tile(self, rows: list[int], columns: list[int], between: dict[tuple[int, int], ComplexValue]) -> None:
        """Write some rows of U in the current columns."""
        totals = self._sums(rows, columns)
        for column in columns:
            self._eliminate(column, totals, between)
        for (row, column), total in totals.items():
            self._store(total, row, column)

    def back_substitute(self) -> None:
        """Write Z, row by row from the last pivot to the first."""
        n, motors = self.structure.n, len(self.structure.motors)
        zero = ComplexValue(self.block.number(0.0), self.block.number(0.0))
        for pivot in reversed(range(n)):
            totals = [
                self.complex.load(self._U, (n + m) * self._stride + pivot) if (n + m, pivot) in self._filled else zero
                for m in range(motors)
            ]
            for run in _runs([row for row in self.elimination.below[pivot] if row < n]):
                totals = self._over(run, totals, self._substitution(pivot, motors))
            inverse = self.complex.load(self._inverse, pivot)
            for m, total in enumerate(totals):
                self.complex.store(self.complex.mul(total, inverse), self.Z, pivot * motors + m)

    def _substitution(self, pivot: int, motors: int) -> _Body:
        """Write what one row of Z subtracts from the row of a pivot."""

        def body(row: int | str, totals: list[ComplexValue]) -> list[ComplexValue]:
            U = self.complex.load(self._at(self._U, row, self._stride), pivot)
            minus_U, Z = self.complex.negative(U), self._at(self.Z, row, motors)
            return [self.complex.add_product(total, minus_U, self.complex.load(Z, m)) for m, total in enumerate(totals)]

        return body

    def finish(self) -> None:
        """Write the sampled responses and the rank-one vectors v = Z^T b."""
        motors = len(self.structure.motors)
        gain = ComplexValue(self.block.load("%hold", 1), self.block.load("%hold", 2))
        scalar = self.block.of_lanes(1)
        for number, (m, n) in enumerate(self.structure.pairs):
            total = self.complex.mul(gain, self.complex.load(self.Z, self._turn[self.structure.motors[m]] * motors + n))
            for order in range(len(ORDERS)):
                alias = ComplexValue(self.block.load("%hold", 3 + 2 * order), self.block.load("%hold", 4 + 2 * order))
                factor = self.block.splat(scalar.load("%expansion", order * len(self.structure.pairs) + number))
                total = self.complex.add_scaled(total, alias, factor)
            self.complex.store(total, "%response", number)
        for number, vector in enumerate(self.structure.vectors):
            for m in range(motors):
                parts = [
                    self.complex.scaled(self._unknown(coordinate, m), self.block.number(coefficient))
                    for coordinate, coefficient in vector
                ]
                total = parts[0]
                for part in parts[1:]:
                    total = self.complex.add(total, part)
                self.complex.store(total, "%vectors", number * motors + m)

    def _unknown(self, coordinate: int, m: int) -> ComplexValue:
        return self.complex.load(self.Z, self._turn[coordinate] * len(self.structure.motors) + m)
