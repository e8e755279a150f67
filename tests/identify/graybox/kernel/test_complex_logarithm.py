"""Complex logarithm of compiled text compared with NumPy."""

from __future__ import annotations

import numpy as np

from flexros.identify.graybox.kernel.complex_logarithm import write_logarithm
from tests.identify.graybox.complex_operations import evaluate, numbers


def test_logarithm() -> None:
    a = np.concatenate([numbers(800, 3), np.exp(1j * np.linspace(-np.pi, np.pi, 400))])
    logarithm = evaluate(lambda w, x, _: write_logarithm(w.block, x), a, a)
    np.testing.assert_allclose(logarithm.real, np.log(np.abs(a)), rtol=1e-15, atol=3e-16)
    np.testing.assert_allclose(logarithm.imag, np.angle(a), rtol=1e-15, atol=3e-16)


def test_logarithm_on_the_axes_and_diagonals() -> None:
    a = np.array([1, -1, 1j, -1j, 1 + 1j, -1 + 1j, -1 - 1j, 1 - 1j]) * 0.3
    logarithm = evaluate(lambda w, x, _: write_logarithm(w.block, x), a, a)
    np.testing.assert_allclose(logarithm, np.log(a), rtol=1e-15)


def test_logarithm_of_what_is_no_number_is_none() -> None:
    logarithm = evaluate(lambda w, x, _: write_logarithm(w.block, x), np.full(8, np.nan + 0j), np.ones(8, complex))
    assert np.all(np.isnan(logarithm.real))
