"""What the arm takes from the motors behind its springs, from their measured motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.torques.arm_torque import arm_torque
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import MODEL, ROBOT, data_of
from tests.gap.rigid_arm import arm, record_of_arm

STIFFNESS = "body_1.rz.stiffness"


def test_behind_springs_friction_shows_that_locked_springs_hide() -> None:
    data = data_of("coulomb_friction@motor_1:level=0.5", "viscous_friction@motor_1:coefficient=0.02")
    found = regress_torque(data.record, MODEL, Tolerance(), arm_torque(data, MODEL, Tolerance()))
    assert found is not None
    locked = regress_torque(data.record, MODEL, Tolerance())
    assert locked is not None
    assert found.left[0] < 0.3 * locked.left[0]
    assert found.coulomb_friction[0] > 0.1  # a first value: speeds are low-passed, so that viscous friction shares it
    assert locked.coulomb_friction[0] == 0.0


def test_torques_that_ran_away_show_nothing() -> None:
    data = data_of("coulomb_friction@motor_1:level=0.5", "viscous_friction@motor_1:coefficient=0.02")
    taken = arm_torque(data, MODEL, Tolerance())
    assert taken is not None
    torque = taken.torque.copy()
    torque[len(torque) // 2 :] = np.nan
    assert regress_torque(data.record, MODEL, Tolerance(), replace(taken, torque=torque)) is None


def test_slopes_are_the_derivatives_to_tolerated_deviations() -> None:
    tolerance, data = Tolerance((STIFFNESS, "motor_1.inertia"), (0.05, 0.05)), data_of()
    nominal = arm_torque(data, MODEL, tolerance)
    softer = RobotWithEffects(ROBOT.with_values({STIFFNESS: ROBOT.parameters[STIFFNESS].value * np.exp(-0.05)}), ())
    moved = arm_torque(data, softer, Tolerance())
    assert nominal is not None
    assert moved is not None
    change, slope = moved.torque - nominal.torque, -nominal.slopes[:, :, 0]
    np.testing.assert_allclose(slope, change, atol=0.1 * np.abs(change).max())
    assert not nominal.slopes[:, :, 1].any()


def test_a_rigid_arm_has_none() -> None:
    model = RobotWithEffects(arm().with_values({"motor_1.inertia": 0.8, "motor_2.inertia": 0.3}), ())
    data = fit_data(record_of_arm(), model, DiagnosisSettings())
    assert arm_torque(data, model, Tolerance()) is None
