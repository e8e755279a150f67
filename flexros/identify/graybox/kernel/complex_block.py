"""Complex arithmetic in LLVM text: pairs of real vectors."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from flexros.compile.ir_text import IrBlock


class ComplexValue(NamedTuple):
    """Names of a real and an imaginary part."""

    re: str
    im: str


class ComplexBlock:
    """Writes complex operations into a block; an array holds real and imaginary parts in turn.

    Products are fused multiply-adds: results agree with other orders of evaluation to rounding, not bit by bit.
    """

    def __init__(self, block: IrBlock) -> None:
        """Write into a block of real numbers."""
        self.block = block

    def load(self, base: str, index: int | str) -> ComplexValue:
        """Load element `index` (an integer or an i64 value) of a complex array."""
        offset = self._double(index)
        imaginary = offset + 1 if isinstance(offset, int) else self.block.value(f"add nsw i64 {offset}, 1")
        return ComplexValue(self.block.load(base, offset), self.block.load(base, imaginary))

    def store(self, number: ComplexValue, base: str, index: int | str) -> None:
        """Store element `index` of a complex array."""
        offset = self._double(index)
        imaginary = offset + 1 if isinstance(offset, int) else self.block.value(f"add nsw i64 {offset}, 1")
        self.block.store(number.re, base, offset)
        self.block.store(number.im, base, imaginary)

    def _double(self, index: int | str) -> int | str:
        return 2 * index if isinstance(index, int) else self.block.value(f"shl nsw i64 {index}, 1")

    def add(self, a: ComplexValue, b: ComplexValue) -> ComplexValue:
        """Write a + b."""
        return ComplexValue(self.block.add(a.re, b.re), self.block.add(a.im, b.im))

    def negative(self, a: ComplexValue) -> ComplexValue:
        """Write -a."""
        return ComplexValue(self._minus(a.re), self._minus(a.im))

    def mul(self, a: ComplexValue, b: ComplexValue) -> ComplexValue:
        """Write a * b."""
        block = self.block
        re = block.fma(a.re, b.re, self._minus(block.mul(a.im, b.im)))
        return ComplexValue(re, block.fma(a.re, b.im, block.mul(a.im, b.re)))

    def add_product(self, total: ComplexValue, a: ComplexValue, b: ComplexValue) -> ComplexValue:
        """Write total + a * b."""
        block = self.block
        re = block.fma(self._minus(a.im), b.im, block.fma(a.re, b.re, total.re))
        return ComplexValue(re, block.fma(a.im, b.re, block.fma(a.re, b.im, total.im)))

    def scaled(self, a: ComplexValue, factor: str) -> ComplexValue:
        """Write a times a real number."""
        return ComplexValue(self.block.mul(a.re, factor), self.block.mul(a.im, factor))

    def add_scaled(self, total: ComplexValue, a: ComplexValue, factor: str) -> ComplexValue:
        """Write total + a times a real number."""
        return ComplexValue(self.block.fma(a.re, factor, total.re), self.block.fma(a.im, factor, total.im))

    def square(self, a: ComplexValue) -> str:
        """Write |a|^2."""
        return self.block.fma(a.re, a.re, self.block.mul(a.im, a.im))

    def inverse(self, a: ComplexValue) -> ComplexValue:
        """Write 1 / a."""
        share = self.block.div(self.block.number(1.0), self.square(a))
        return ComplexValue(self.block.mul(a.re, share), self.block.mul(self._minus(a.im), share))

    def _minus(self, a: str) -> str:
        return self.block.value(f"fneg {self.block.type} {a}")
