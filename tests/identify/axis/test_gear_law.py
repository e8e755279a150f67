"""Laws of the gear."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.identify.axis.gear_law import PARAMETERS, GearLaw, gear_torque

VALUES = {"gear_stiffness": 100.0, "gear_stiffening": 3.0, "gear_knee": 0.2, "gear_doubling": 0.5}


def torque(law: GearLaw, deflection: float, **changed: float) -> float:
    values = {name: ca.SX(value) for name, value in (VALUES | changed).items()}
    return float(ca.DM(gear_torque(law, ca.SX(deflection), values)))


@pytest.mark.parametrize(
    ("law", "expected"),
    [("linear", [10.0, 20.0, 60.0]), ("piecewise", [10.0, 20.0, 140.0]), ("cubic", [10.4, 23.2, 146.4])],
)
def test_law(law: GearLaw, expected: list[float]) -> None:
    assert [torque(law, d) for d in (0.1, 0.2, 0.6)] == pytest.approx(expected)
    assert [torque(law, -d) for d in (0.1, 0.2, 0.6)] == pytest.approx([-value for value in expected])


def test_stiffening_of_one_is_the_linear_law() -> None:
    for deflection in np.linspace(-1, 1, 9):
        assert torque("piecewise", deflection, gear_stiffening=1.0) == torque("linear", deflection)


def test_every_law_lists_its_parameters() -> None:
    names = {name for law in PARAMETERS.values() for name in law}
    assert names | {"gear_stiffness"} == set(VALUES)
