"""Names, units and factors of the quantities."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.frf.quantity import QUANTITIES, derivative_order, differentiation, unit_of_quantity


@pytest.mark.parametrize(("quantity", "unit"), list(zip(QUANTITIES, ("m", "m/s", "m/s²"))))
def test_every_quantity_has_its_unit(quantity: str, unit: str) -> None:
    assert unit_of_quantity("m", quantity) == unit


def test_differentiation_multiplies_by_jw() -> None:
    np.testing.assert_allclose(differentiation(np.array([1.0]), derivative_order("acceleration")), -4 * np.pi**2)
    np.testing.assert_allclose(differentiation(np.array([1.0]), -1), 1 / (2j * np.pi))
