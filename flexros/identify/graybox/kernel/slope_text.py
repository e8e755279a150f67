"""LLVM text of Z^T (dA/dtheta) Z for parameters that are not rank-one terms (masses, inertias, lengths)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.identify.graybox.kernel.complex_block import ComplexBlock, ComplexValue

if TYPE_CHECKING:
    from flexros.compile.ir_text import IrBlock, IrLoop
    from flexros.identify.graybox.kernel.structure import KernelStructure


class SlopeWriter:
    """Writes the products of all slopes into a block, with loops over slopes, rows and columns."""

    def __init__(self, structure: KernelStructure, block: IrBlock, solution: str, omega: str) -> None:
        """Prepare.

        Args:
            structure: Structure of the model.
            block: Where to write; the pointers %matrices and %vectors are known there.
            solution: Pointer to Z, complex, (n, M) in the order of elimination.
            omega: Angular frequency.
        """
        self.structure, self.block, self.complex = structure, block, ComplexBlock(block)
        self._Z, self._omega = solution, omega
        self._minus_square = block.value(f"fneg {block.type} {block.mul(omega, omega)}")

    def write(self) -> None:
        """Write all products; nothing where there are no slopes."""
        if not self.structure.n_slopes:
            return
        block, pairs = self.block, len(self.structure.pairs)
        with block.loop(0, self.structure.n_slopes) as slope:
            offset = block.value(f"mul nsw i64 {slope.index}, {2 * pairs}")
            first = 2 * len(self.structure.vectors) * len(self.structure.motors)
            result = block.pointer("%vectors", block.value(f"add nsw i64 {offset}, {first}"))
            for number in range(2 * pairs):
                block.store(block.number(0.0), result, number)
            with block.loop(self.structure.sloped.start, self.structure.sloped.stop) as row:
                self._add_row(result, row, self._product_row(slope, row))

    def _matrix_row(self, slope: IrLoop, row: IrLoop) -> str:
        """Write the address of a row of a slope, minus the columns before the sloped ones."""
        block, scalar, sloped = self.block, self.block.of_lanes(1), self.structure.sloped
        width = len(sloped)
        turn = block.value(f"mul nsw i64 {slope.index}, {3 * width * width}")
        line = block.value(f"mul nsw i64 {row.index}, {3 * width}")
        start = 3 * len(self.structure.entries) - 3 * width * sloped.start - 3 * sloped.start
        offset = block.value(f"add nsw i64 {block.value(f'add nsw i64 {turn}, {line}')}, {start}")
        return scalar.pointer("%matrices", offset)

    def _product_row(self, slope: IrLoop, row: IrLoop) -> list[ComplexValue]:
        """Write one row of (dA/dtheta) Z, M complex numbers."""
        block, motors = self.block, len(self.structure.motors)
        matrix, scalar = self._matrix_row(slope, row), block.of_lanes(1)
        start = [(block.type, block.number(0.0))] * (2 * motors)
        with block.loop(self.structure.sloped.start, self.structure.sloped.stop, carry=start) as column:
            entry = scalar.pointer(matrix, block.value(f"mul nsw i64 {column.index}, 3"))
            K, M, D = (block.splat(scalar.load(entry, part)) for part in range(3))
            a = ComplexValue(block.fma(self._minus_square, M, K), block.mul(self._omega, D))
            Z = self._row_of_solution(column)
            for m in range(motors):
                total = ComplexValue(column.values[2 * m], column.values[2 * m + 1])
                column.next_values += self.complex.add_product(total, a, self.complex.load(Z, m))
        return [ComplexValue(re, im) for re, im in zip(column.values[::2], column.values[1::2], strict=True)]

    def _add_row(self, result: str, row: IrLoop, product: list[ComplexValue]) -> None:
        """Add the contribution of a row to Z^T (dA/dtheta) Z."""
        Z = self._row_of_solution(row)
        for number, (m, n) in enumerate(self.structure.pairs):
            total = self.complex.add_product(self.complex.load(result, number), self.complex.load(Z, m), product[n])
            self.complex.store(total, result, number)

    def _row_of_solution(self, row: IrLoop) -> str:
        doubles = 2 * len(self.structure.motors)
        return self.block.pointer(self._Z, self.block.value(f"mul nsw i64 {row.index}, {doubles}"))
