"""LLVM text of the weighted errors, their derivatives and the sums of products of the normal equations.

For element e of the symmetric response and rank-one vector j let X_je = sqrt(w_e) f_e v_jm v_jn with f_e = gain / G_e
(NLS: gain), w_e the sum of the weights of (m, n) and (n, m). A parameter of vector j and power k has the derivative
-theta s (jw)^k X_je, so that all products of derivatives follow from few sums over the elements:

    S_ij = sum_e conj(X_ie) X_je,    w^(k+k') Re(conj(j^k) j^k' S_ij),

or, where only magnitudes are compared, from those of the real and imaginary parts. The weighted error is one more
column, which gives the gradient. A parameter that is not a rank-one term has its product in place of v_jm v_jn.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from flexros.compile.ir_text import IrBlock
from flexros.identify.graybox.kernel.complex_block import ComplexBlock, ComplexValue
from flexros.identify.graybox.kernel.complex_logarithm import write_logarithm
from flexros.identify.graybox.kernel.structure import LANES

if TYPE_CHECKING:
    from flexros.compile.ir_text import IrLoop
    from flexros.identify.graybox.kernel.structure import KernelStructure

TARGET_NUMBERS = 8
"""Numbers per element in packed targets: measured (complex) and weight of (m, n), of (n, m), sqrt(w_e), its inverse."""
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding it rounds to an integer


class ProductPair(NamedTuple):
    """Two columns of derivatives: indices of their vectors, and powers; the error is vector J with power 0."""

    first: int
    second: int


@lru_cache(maxsize=64)
def product_pairs(structure: KernelStructure) -> tuple[ProductPair, ...]:
    """Pairs of columns (parameters, then the error) whose products are summed, in the order of the sums.

    Args:
        structure: Structure of the model.
    """
    count = len(structure.parameters)
    return tuple(ProductPair(a, b) for a in range(count) for b in range(a, count + 1))


def equations_text(structure: KernelStructure, symbol: str, estimator: str) -> str:
    """Write `void @symbol(ptr hold, ptr target, ptr response, ptr vectors, ptr sums)`.

    It adds the contribution of a block of frequencies. `sums` holds the cost, then the sum of each product pair,
    per lane.

    Args:
        structure: Structure of the model.
        symbol: Name of the function.
        estimator: "LLS", "LLSM" or "NLS".
    """
    writer = _EquationsWriter(structure, estimator)
    writer.columns()
    writer.products()
    arguments = ", ".join(f"ptr noalias %{name}" for name in ("hold", "target", "response", "vectors", "sums"))
    return f"define internal void @{symbol}({arguments}) nounwind {{\nentry:\n{writer.block.text()}\n  ret void\n}}"


class _EquationsWriter:
    """Writes the table of columns X, element after element, then its products."""

    def __init__(self, structure: KernelStructure, estimator: str) -> None:
        self.structure, self.estimator = structure, estimator
        self.block = IrBlock(LANES)
        self.complex = ComplexBlock(self.block)
        self._n_columns = len(structure.vectors) + structure.n_slopes + 1
        elements = len(structure.pairs)
        self._X = self.block.value(f"alloca {self.block.type}, i64 {2 * elements * self._n_columns}, align 64")
        self._omega = self.block.load("%hold", 0)
        self._gain = ComplexValue(self.block.load("%hold", 1), self.block.load("%hold", 2))

    def columns(self) -> None:
        """Write the table and the cost."""
        motors = len(self.structure.motors)
        block = self.block
        start = [("i64", "0"), (block.type, block.load("%sums", 0))]
        with block.loop(0, motors, carry=start) as m:
            with block.loop(m.index, motors, carry=list(zip(("i64", block.type), m.values, strict=True))) as n:
                element, cost = n.values
                cost = block.add(cost, self._element(element, m, n))
                n.next_values = [block.value(f"add nsw i64 {element}, 1"), cost]
            m.next_values = n.values
        block.store(m.values[1], "%sums", 0)

    def _element(self, element: str, m: IrLoop, n: IrLoop) -> str:
        """Write the columns of one element; return its cost."""
        block = self.block
        numbers = block.pointer("%target", block.value(f"mul nsw i64 {element}, {TARGET_NUMBERS}"))
        root, inverse_root = block.load(numbers, 6), block.load(numbers, 7)
        response = self.complex.load("%response", element)
        if self.estimator != "NLS":  # elements without weight may be zero
            counted = block.compare("ogt", root, block.number(0.0))
            response = ComplexValue(
                block.select(counted, response.re, block.number(1.0)),
                block.select(counted, response.im, block.number(0.0)),
            )
        error, cost = self._weighted_error(numbers, response)
        factor = self._gain
        if self.estimator != "NLS":
            factor = self.complex.mul(factor, self.complex.inverse(response))
        factor = self.complex.scaled(factor, root)
        row = block.value(f"mul nsw i64 {element}, {self._n_columns}")
        for j in range(self._n_columns - 1):
            column = self.complex.mul(self._factor(j, element, m, n), factor)
            self.complex.store(column, self._X, block.value(f"add nsw i64 {row}, {j}"))
        last = block.value(f"add nsw i64 {row}, {self._n_columns - 1}")
        self.complex.store(self.complex.scaled(error, inverse_root), self._X, last)
        return cost

    def _factor(self, j: int, element: str, m: IrLoop, n: IrLoop) -> ComplexValue:
        """Write the product v_m v_n of a vector, or the product Z^T (dA/dtheta) Z of a slope."""
        motors, slope = len(self.structure.motors), j - len(self.structure.vectors)
        if slope >= 0:
            first = len(self.structure.vectors) * motors + slope * len(self.structure.pairs)
            return self.complex.load("%vectors", self.block.value(f"add nsw i64 {element}, {first}"))
        offsets = [self.block.value(f"add nsw i64 {loop.index}, {j * motors}") for loop in (m, n)]
        v, other = (self.complex.load("%vectors", offset) for offset in offsets)
        return self.complex.mul(v, other)

    def _weighted_error(self, numbers: str, response: ComplexValue) -> tuple[ComplexValue, str]:
        """Write the sum of weight times error of (m, n) and (n, m), and their cost."""
        block, zero = self.block, self.block.number(0.0)
        model = response if self.estimator == "NLS" else write_logarithm(block, response)
        total, cost = ComplexValue(zero, zero), zero
        for first in (0, 3):
            re = block.sub(block.load(numbers, first), model.re)
            im = block.sub(block.load(numbers, first + 1), model.im)
            weight = block.load(numbers, first + 2)
            if self.estimator == "LLSM":
                im = zero
            elif self.estimator == "LLS":
                im = self._wrapped(im)
            error = ComplexValue(re, im)
            total = self.complex.add_scaled(total, error, weight)
            cost = block.fma(self.complex.square(error), weight, cost)
        return total, cost

    def _wrapped(self, angle: str) -> str:
        """Write an angle minus whole turns, within [-pi, pi]."""
        block = self.block
        turns = block.fma(angle, block.number(0.5 / math.pi), block.number(_ROUND))
        turns = block.sub(turns, block.number(_ROUND))
        return block.fma(turns, block.number(-2.0 * math.pi), angle)

    def products(self) -> None:
        """Write the sums of products of all columns, in tiles whose sums stay in registers."""
        powers = [self.block.number(1.0), self._omega]
        while len(powers) < 5:
            powers.append(self.block.mul(powers[-1], self._omega))
        tile = 2 if self.estimator == "LLSM" else 3
        groups = [range(start, min(start + tile, self._n_columns)) for start in range(0, self._n_columns, tile)]
        for number, left in enumerate(groups):
            for right in groups[number:]:
                entries = [(i, j) for i in left for j in right if i <= j and i != self._n_columns - 1]
                if entries:
                    self._distribute(self._tile(entries), powers)

    def _tile(self, entries: list[tuple[int, int]]) -> dict[tuple[int, int], list[str]]:
        """Write the sums over elements of the products of some columns.

        For each pair of columns Re S and Im S; where only magnitudes count, the products real by real,
        imaginary by imaginary, real by imaginary and imaginary by real part.
        """
        block = self.block
        each = 4 if self.estimator == "LLSM" else 2
        start = [(block.type, block.number(0.0))] * (each * len(entries))
        with block.loop(0, len(self.structure.pairs), carry=start) as element:
            row = block.value(f"mul nsw i64 {element.index}, {2 * self._n_columns}")
            base = block.pointer(self._X, row)
            used = sorted({column for entry in entries for column in entry})
            X = {column: self.complex.load(base, column) for column in used}
            for number, (i, j) in enumerate(entries):
                old = element.values[each * number : each * (number + 1)]
                element.next_values += self._products(X[i], X[j], old)
        return {entry: element.values[each * k : each * (k + 1)] for k, entry in enumerate(entries)}

    def _products(self, a: ComplexValue, b: ComplexValue, old: list[str]) -> list[str]:
        block = self.block
        if self.estimator == "LLSM":
            factors = ((a.re, b.re), (a.im, b.im), (a.re, b.im), (a.im, b.re))
            return [block.fma(x, y, total) for (x, y), total in zip(factors, old, strict=True)]
        real = block.fma(a.im, b.im, block.fma(a.re, b.re, old[0]))
        minus = block.value(f"fneg {block.type} {a.im}")
        return [real, block.fma(minus, b.re, block.fma(a.re, b.im, old[1]))]

    def _distribute(self, sums: dict[tuple[int, int], list[str]], powers: list[str]) -> None:
        """Distribute the sums of vectors to the pairs of parameters (and the error)."""
        columns = [*self.structure.parameters, (self._n_columns - 1, 0)]
        for number, (first, second) in enumerate(product_pairs(self.structure)):
            (i, k), (j, other) = columns[first], columns[second]
            if (i, j) not in sums:
                (i, k), (j, other) = (j, other), (i, k)
            if (i, j) not in sums:
                continue
            value, negative = self._product(sums[i, j], k, other)
            factor = powers[k + other]
            if negative:
                value = self.block.value(f"fneg {self.block.type} {value}")
            old = self.block.load("%sums", number + 1)
            self.block.store(self.block.fma(value, factor, old), "%sums", number + 1)

    def _product(self, sums: list[str], k: int, other: int) -> tuple[str, bool]:
        """Choose the sum for powers k and k', and its sign."""
        if self.estimator != "LLSM":  # Re(j^(k' - k) S)
            turn = (other - k) % 4
            return sums[turn % 2], turn in (1, 2)
        # real part of j^k X: Re X, -Im X, -Re X
        index = {(0, 0): 0, (1, 1): 1, (0, 1): 2, (1, 0): 3}[k % 2, other % 2]
        return sums[index], (k > 0) != (other > 0)
