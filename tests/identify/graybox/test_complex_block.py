"""Complex arithmetic of compiled text beside NumPy."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.ir_text import IrBlock
from flexros.compile.module_builder import ModuleBuilder
from flexros.identify.graybox.complex_block import ComplexBlock, ComplexValue
from flexros.identify.graybox.complex_logarithm import write_logarithm

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


def test_products_and_sums() -> None:
    a, b = numbers(80, 0), numbers(80, 1)
    np.testing.assert_allclose(evaluate(lambda w, x, y: w.mul(x, y), a, b), a * b, rtol=1e-14)
    np.testing.assert_allclose(evaluate(lambda w, x, y: w.add(x, w.negative(y)), a, b), a - b, rtol=1e-14)
    found = evaluate(lambda w, x, y: w.add_product(x, x, y), a, b)
    assert np.max(np.abs(found - a * (1 + b)) / (np.abs(a) * (1 + np.abs(b)))) < 1e-15
    found = evaluate(lambda w, x, y: w.add_scaled(x, y, w.block.number(3.0)), a, b)
    assert np.max(np.abs(found - a - 3 * b) / (np.abs(a) + 3 * np.abs(b))) < 1e-15


def test_inverse() -> None:
    a = numbers(80, 2)
    np.testing.assert_allclose(evaluate(lambda w, x, _: w.inverse(x), a, a), 1 / a, rtol=1e-14)


def test_logarithm() -> None:
    a = np.concatenate([numbers(800, 3), np.exp(1j * np.linspace(-np.pi, np.pi, 400))])
    found = evaluate(lambda w, x, _: write_logarithm(w.block, x), a, a)
    np.testing.assert_allclose(found.real, np.log(np.abs(a)), rtol=1e-15, atol=3e-16)
    np.testing.assert_allclose(found.imag, np.angle(a), rtol=1e-15, atol=3e-16)


def test_logarithm_on_the_axes_and_diagonals() -> None:
    a = np.array([1, -1, 1j, -1j, 1 + 1j, -1 + 1j, -1 - 1j, 1 - 1j]) * 0.3
    found = evaluate(lambda w, x, _: write_logarithm(w.block, x), a, a)
    np.testing.assert_allclose(found, np.log(a), rtol=1e-15)


def test_logarithm_of_what_is_no_number_is_none() -> None:
    found = evaluate(lambda w, x, _: write_logarithm(w.block, x), np.full(8, np.nan + 0j), np.ones(8, complex))
    assert np.all(np.isnan(found.real))
