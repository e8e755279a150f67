"""A torque that moves a motor as it was measured to move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.record.prescribed_motion import INERTIA, motors_named, with_prescribed_motion, without_prescribed
from tests.gap.rigid_arm import T, arm, motion, record_of_arm


def test_the_torque_is_that_of_the_measured_acceleration() -> None:
    record = with_prescribed_motion(record_of_arm(), arm(), [1], "a test")
    acceleration = motion()[2][:, 1]
    middle = 0.5 * (acceleration[:-1] + acceleration[1:])
    np.testing.assert_allclose(record.torque[50:-50, 1] / INERTIA, middle[50:-49], atol=0.01 * np.abs(middle).max())
    np.testing.assert_array_equal(record.torque[:, 0], record_of_arm().torque[:, 0])
    assert not without_prescribed(record).torque[:, 1].any()
    assert with_prescribed_motion(record, arm(), [1], "another test") is record


def test_a_commanded_torque_is_ahead_by_the_delay_of_the_robot() -> None:
    late, commanded = arm().with_values({"delay": 4 * T}), replace(record_of_arm(), measured_torque=False)
    torque = with_prescribed_motion(commanded, late, [1], "a test").torque[:, 1]
    at_once = with_prescribed_motion(commanded, arm(), [1], "a test").torque[:, 1]
    np.testing.assert_allclose(torque[:-4], at_once[4:], rtol=1e-9, atol=1e-6 * INERTIA)


def test_measured_torques_of_such_a_motor_are_not_known() -> None:
    record = with_prescribed_motion(replace(record_of_arm(), noted=record_of_arm().torque), arm(), [0], "a test")
    assert record.noted is not None
    assert np.isnan(record.noted[:, 0]).all()
    assert np.isfinite(record.noted[:, 1]).all()


def test_one_motor_at_least_must_be_predicted() -> None:
    record = with_prescribed_motion(record_of_arm(), arm(), [0], "a test")
    with pytest.raises(InputError, match=r"log: the motion of every motor would be prescribed \(another test\)"):
        with_prescribed_motion(record, arm(), [1], "another test")


def test_motors_are_named_as_in_the_robot_file() -> None:
    assert motors_named(arm(), ("motor_2", "motor_1", "motor_2")) == (0, 1)
    with pytest.raises(InputError, match="motor_1"):
        motors_named(arm(), ("elbow",))
