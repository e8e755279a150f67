"""Machine code for frequency responses and normal equations of one structure; matrices are arguments."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import lru_cache
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.ir_text import IrBlock
from flexros.compile.machine_code import can_compile
from flexros.compile.module_builder import ModuleBuilder
from flexros.identify.frf.sampled import ORDERS
from flexros.identify.graybox.kernel.normal_equations_text import TARGET_NUMBERS, equations_text, product_pairs
from flexros.identify.graybox.kernel.solution_text import solution_text
from flexros.identify.graybox.kernel.structure import LANES, KernelStructure

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

MOST_PRODUCTS = 12_000
"""Complex products per frequency up to which unrolled code is worth compiling (about 45 coordinates, chosen)."""
ESTIMATORS = ("LLS", "LLSM", "NLS")
_COMPILING = Lock()  # threads that fit the same robot wait for one compilation


@dataclass(frozen=True, eq=False)
class KernelResponse:
    """Responses of some positions in blocks of frequencies.

    Attributes:
        responses: Real and imaginary parts in turn, shape (Q, blocks, 2 pairs, LANES).
        factors: Factors of the derivatives in the same form, shape (Q, blocks, 2 factor_numbers, LANES).
    """

    responses: FloatArray
    factors: FloatArray

    def of(self, positions: slice) -> KernelResponse:
        """Return a view of some positions."""
        return KernelResponse(self.responses[positions], self.factors[positions])


@dataclass(frozen=True, eq=False)
class KernelSums:
    """Sums of the normal equations.

    Attributes:
        sums: Cost and product pairs of every position, shape (Q, 1 + pairs).
        small_pivots: Number of pivots that require an exchange of rows.
    """

    sums: FloatArray
    small_pivots: int


class FrequencyKernel:
    """Compiled code of one structure, thread-safe; calls release the GIL.

    Packed arrays are those of `kernel_structure`; all are contiguous.

    Attributes:
        structure: Structure of the code.
        pairs: First and second column of every product pair, shape (2, pairs); see `product_pairs`.
        n_sums: Sums per position: the cost and the product pairs.
    """

    def __init__(self, structure: KernelStructure) -> None:
        """Write and compile the code."""
        self.structure = structure
        self.pairs = np.array(product_pairs(structure), dtype=np.int64).reshape(-1, 2).T
        self.n_sums = 1 + self.pairs.shape[1]
        builder = ModuleBuilder()
        builder.add_text(solution_text(structure, "solution"))
        builder.add_text(_response_driver(structure))
        for estimator in ESTIMATORS:
            builder.add_text(equations_text(structure, f"block.{estimator}", estimator))
            builder.add_text(_equations_driver(structure, estimator))
        self._code = builder.build()
        signature = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 6)
        self._response = signature(self._code.address("responses"))
        self._equations = {name: signature(self._code.address(f"equations.{name}")) for name in ESTIMATORS}

    def response(self, matrices: FloatArray, hold: FloatArray, expansion: FloatArray, results: KernelResponse) -> int:
        """Evaluate sampled responses and the factors of their Jacobian.

        Args:
            matrices: Packed matrices, shape (Q, matrix_numbers).
            hold: Packed hold, shape (Q, blocks, numbers, LANES).
            expansion: Packed expansion, shape (Q, orders, pairs).
            results: Arrays to be filled.

        Returns:
            Number of pivots that require an exchange of rows.
        """
        small = np.zeros(LANES)
        arrays = (matrices, hold, expansion, results.responses, results.factors, small)
        self._response(*hold.shape[:2], *(array.ctypes.data for array in arrays))
        return int(small.sum())

    def allocate(self, n_positions: int, n_blocks: int) -> KernelResponse:
        """Allocate arrays for the responses of some positions and blocks."""
        structure = self.structure
        return KernelResponse(
            np.empty((n_positions, n_blocks, 2 * len(structure.pairs), LANES)),
            np.empty((n_positions, n_blocks, 2 * structure.factor_numbers, LANES)),
        )

    def sums(
        self, estimator: str, matrices: FloatArray, hold: FloatArray, expansion: FloatArray, target: FloatArray
    ) -> KernelSums:
        """Evaluate the sums of normal equations.

        Args:
            estimator: "LLS", "LLSM" or "NLS".
            matrices: Packed matrices, shape (Q, matrix_numbers).
            hold: Packed hold, shape (Q, blocks, numbers, LANES).
            expansion: Packed expansion, shape (Q, orders, pairs).
            target: Packed target, shape (Q, blocks, pairs * TARGET_NUMBERS, LANES).

        Returns:
            Cost and product pairs of every position.
        """
        n_positions, n_blocks = hold.shape[:2]
        sums = np.zeros((n_positions, self.n_sums, LANES))
        small = np.zeros(LANES)
        arrays = (matrices, hold, expansion, target, sums, small)
        self._equations[estimator](n_positions, n_blocks, *(array.ctypes.data for array in arrays))
        return KernelSums(sums.sum(axis=-1), int(small.sum()))


def kernel_for(structure: KernelStructure) -> FrequencyKernel | None:
    """Return the compiled code of a structure, compiled once; None where it is too large or there is no compiler."""
    if not can_compile() or structure.elimination.products > MOST_PRODUCTS:
        return None
    with _COMPILING:
        return _kernel(structure)


@lru_cache(maxsize=16)
def _kernel(structure: KernelStructure) -> FrequencyKernel:
    return FrequencyKernel(structure)


_ARGUMENTS = "i64 %positions, i64 %blocks, ptr %matrices, ptr %hold, ptr %expansion, ptr %{}, ptr %{}, ptr %small"


def _response_driver(structure: KernelStructure) -> str:
    """Write the loop over positions and blocks that stores responses and factors."""
    block = IrBlock()
    sizes = {"responses": 2 * len(structure.pairs), "vectors": 2 * structure.factor_numbers}
    with block.loop(0, "%positions") as position:
        matrices, expansion = _of_position(block, structure, position.index)
        first = block.value(f"mul nsw i64 {position.index}, %blocks")
        with block.loop(0, "%blocks") as number:
            item = block.value(f"add nsw i64 {first}, {number.index}")
            hold = _element(block, "%hold", item, structure.hold_numbers * LANES)
            results = [_element(block, f"%{name}", item, size * LANES) for name, size in sizes.items()]
            pointers = ", ".join(f"ptr {name}" for name in (matrices, hold, expansion, *results, "%small"))
            block.emit(f"call void @solution({pointers})")
    return f"define void @responses({_ARGUMENTS.format(*sizes)}) nounwind {{\nentry:\n{block.text()}\n  ret void\n}}"


def _equations_driver(structure: KernelStructure, estimator: str) -> str:
    """Write the loop over positions and blocks that adds up the sums of each position."""
    block = IrBlock()
    scratch = block.of_lanes(LANES)
    response, vectors = (
        block.value(f"alloca {scratch.type}, i64 {2 * size}, align 64")
        for size in (len(structure.pairs), structure.factor_numbers)
    )
    with block.loop(0, "%positions") as position:
        matrices, expansion = _of_position(block, structure, position.index)
        sums = _element(block, "%sums", position.index, (1 + len(product_pairs(structure))) * LANES)
        first = block.value(f"mul nsw i64 {position.index}, %blocks")
        with block.loop(0, "%blocks") as number:
            item = block.value(f"add nsw i64 {first}, {number.index}")
            hold = _element(block, "%hold", item, structure.hold_numbers * LANES)
            target = _element(block, "%target", item, len(structure.pairs) * TARGET_NUMBERS * LANES)
            pointers = (matrices, hold, expansion, response, vectors, "%small")
            block.emit(f"call void @solution({', '.join(f'ptr {name}' for name in pointers)})")
            inputs = (hold, target, response, vectors, sums)
            block.emit(f"call void @block.{estimator}({', '.join(f'ptr {name}' for name in inputs)})")
    head = f"define void @equations.{estimator}({_ARGUMENTS.format('target', 'sums')}) nounwind"
    return f"{head} {{\nentry:\n{block.text()}\n  ret void\n}}"


def _of_position(block: IrBlock, structure: KernelStructure, position: str) -> tuple[str, str]:
    matrices = _element(block, "%matrices", position, structure.matrix_numbers)
    return matrices, _element(block, "%expansion", position, len(ORDERS) * len(structure.pairs))


def _element(block: IrBlock, base: str, number: str, size: int) -> str:
    """Write the address of item `number` of an array of items of `size` doubles."""
    return block.pointer(base, block.value(f"mul nsw i64 {number}, {size}"))
