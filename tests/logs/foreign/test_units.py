"""Units of foreign logs."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.foreign.units import UNITS, units_of


@pytest.mark.parametrize(
    ("unit", "value", "si"),
    [("deg", 180.0, np.pi), ("rpm", 60.0, 2 * np.pi), ("mm", 5.0, 5e-3), ("kNm", 2.0, 2000.0), ("turn", 0.5, np.pi)],
)
def test_unit_in_si(unit: str, value: float, si: float) -> None:
    assert value * UNITS[unit].factor == pytest.approx(si, rel=1e-15)


def test_units_of_a_kind() -> None:
    assert units_of("torque") == ["Nm", "mNm", "kNm", "N", "kN"]
