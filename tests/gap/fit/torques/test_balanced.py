"""A counterbalance beside friction and rotors, where one motor shows that it has one."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.torques.balanced import regress_balanced
from flexros.gap.settings import TorqueStartSettings
from tests.gap.rigid_arm import COULOMB, VISCOUS, arm, record_of_arm


@pytest.mark.parametrize("balance", [(0.0, 0.0), (60.0, 10.0)])
def test_a_counterbalance_is_fitted_where_there_is_one(balance: tuple[float, float]) -> None:
    record, tolerance = record_of_arm(rotors=(0.12, 0.0), balance=balance), tolerance_of(arm(), {})
    found = regress_balanced(record, RobotWithEffects(arm(), ()), tolerance, settings=TorqueStartSettings())
    assert found is not None
    assert set(found.balance) == ({0} if any(balance) else set())
    for numbers in found.balance.values():
        np.testing.assert_allclose(numbers, balance, rtol=0.05)
    assert abs(found.inertia[0] - 0.12) < 3 * found.inertia_deviation[0] < 0.1
    np.testing.assert_allclose(found.viscous_friction, VISCOUS, rtol=0.03)
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.03)
