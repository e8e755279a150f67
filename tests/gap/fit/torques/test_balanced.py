"""Torques over the position of motors beside friction and rotors, where they show."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.torques.balanced import regress_balanced
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.settings import TorqueStartSettings
from tests.gap.rigid_arm import COULOMB, VISCOUS, arm, record_of_arm


@pytest.mark.parametrize("balance", [(0.0, 0.0), (60.0, 10.0), (20.0, 2.0)])
def test_a_counterbalance_is_fitted_where_there_is_one(balance: tuple[float, float]) -> None:
    """The last one carries a third of the largest torque: else masses and centres stand for it at their limits."""
    record, tolerance = record_of_arm(rotors=(0.12, 0.0), balance=balance), tolerance_of(arm(), {})
    found = regress_balanced(record, RobotWithEffects(arm(), ()), tolerance, settings=TorqueStartSettings())
    assert found is not None
    assert [one.motor for one in found.position_torques] == ([0] if any(balance) else [])
    for torque in found.position_torques:
        np.testing.assert_allclose(torque.sizes, balance, rtol=0.05)
    assert abs(found.inertia[0] - 0.12) < 3 * found.inertia_deviation[0] < 0.1
    np.testing.assert_allclose(found.viscous_friction, VISCOUS, rtol=0.03)
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.03)


def test_a_cable_whose_torque_has_no_law_is_a_curve_that_hides_no_rotor() -> None:
    """Of a joint that goes to and fro the torque of a stiff cable looks like an inertia less than none.

    The counterbalance of the other motor is found beside it.
    """
    cable, balance = (30.0, 30.0), (60.0, 10.0)
    record, model = record_of_arm(rotors=(0.12, 0.4), balance=balance, cable=cable), RobotWithEffects(arm(), ())
    plain = regress_torque(record, model, tolerance_of(arm(), {}))
    found = regress_balanced(record, model, tolerance_of(arm(), {}), settings=TorqueStartSettings())
    assert plain is not None
    assert found is not None
    assert plain.inertia[1] == 0
    assert abs(found.inertia[1] - 0.4) < 3 * found.inertia_deviation[1] < 0.4
    assert {one.motor: one.effect.name for one in found.position_torques} == {0: "counterbalance", 1: "torque_curve"}
    (curve,) = (one for one in found.position_torques if one.span is not None)
    low, high = curve.span
    pulled = np.linspace(low, high, len(curve.sizes)) - record.position[:, 1].mean()
    np.testing.assert_allclose(curve.sizes, -cable[0] * pulled - cable[1] * pulled**3, atol=0.05 * curve.amplitude)


def test_wrong_masses_and_centres_are_no_counterbalance() -> None:
    """One would take them back within their tolerance, but links that are as far off leave less without it."""
    file = arm().with_values({"body_1.center_of_mass.x": 0.3, "body_2.mass": 3.6})
    record, settings = (
        record_of_arm(imported=True, seconds=10.0),
        TorqueStartSettings(least_taken_back=20.0, carried_little=0.1),
    )
    tolerance = tolerance_of(file, {"inertia": 0.01})
    found = regress_balanced(record, RobotWithEffects(file, ()), tolerance, settings=settings)
    assert found is not None
    assert found.position_torques == ()
