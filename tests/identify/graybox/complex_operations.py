"""Operations of complex text compiled and applied to arrays."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.ir_text import IrBlock
from flexros.compile.module_builder import ModuleBuilder
from flexros.identify.graybox.kernel.complex_block import ComplexBlock, ComplexValue

if TYPE_CHECKING:
    from collections.abc import Callable

LANES = 8


def evaluate(
    write: Callable[[ComplexBlock, ComplexValue, ComplexValue], ComplexValue], a: np.ndarray, b: np.ndarray
) -> np.ndarray:
    """Compile an operation of two numbers and apply it to arrays whose length is a multiple of the lanes."""
    block = IrBlock(LANES)
    writer = ComplexBlock(block)
    result = write(writer, writer.load("%a", 0), writer.load("%b", 0))
    writer.store(result, "%c", 0)
    builder = ModuleBuilder()
    builder.add_text(f"define void @f(ptr %a, ptr %b, ptr %c) {{\nentry:\n{block.text()}\n  ret void\n}}")
    code = builder.build()
    function = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(code.address("f"))
    results = []
    for start in range(0, len(a), LANES):
        parts = [
            np.ascontiguousarray([z[start : start + LANES].real, z[start : start + LANES].imag])
            for z in (a, b, np.zeros(len(a), complex))
        ]
        function(*(part.ctypes.data for part in parts))
        results.append(parts[2][0] + 1j * parts[2][1])
    return np.concatenate(results)


def numbers(count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return 10.0 ** rng.uniform(-8, 8, count) * np.exp(1j * rng.uniform(-np.pi, np.pi, count))
