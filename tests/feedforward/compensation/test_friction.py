from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.feedforward.compensation.friction import friction_torque
from flexros.feedforward.specification import FrictionCompensation


def test_parts_of_the_law() -> None:
    friction = FrictionCompensation(
        viscous=2.0, coulomb=5.0, stribeck=3.0, stribeck_velocity=0.2, smoothing_velocity=1e-4
    )
    torque = friction_torque(friction, np.array([[1e-9], [0.2], [-0.2], [10.0]]))[:, 0]
    assert torque[0] == pytest.approx(8.0 * 1e-5, rel=1e-3)
    assert torque[1] == pytest.approx(0.4 + 5.0 + 3.0 / np.e, rel=1e-12)
    assert torque[2] == -torque[1]
    assert torque[3] == pytest.approx(25.0)


def test_standstill_needs_no_torque() -> None:
    assert not friction_torque(FrictionCompensation(coulomb=5.0), np.zeros((3, 2))).any()


def test_one_value_per_motor() -> None:
    torque = friction_torque(FrictionCompensation(viscous=(1.0, 10.0)), np.ones((4, 2)))
    np.testing.assert_allclose(torque, np.tile([1.0, 10.0], (4, 1)))


def test_wrong_number_of_values() -> None:
    with pytest.raises(
        InputError, match=r"feedforward.friction.coulomb has 3 values, allowed is one, or one for each of the 2 motors"
    ):
        friction_torque(FrictionCompensation(coulomb=(1.0, 2.0, 3.0)), np.ones((4, 2)))
