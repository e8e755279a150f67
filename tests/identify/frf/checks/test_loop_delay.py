"""Delays between torque and motion, from the phase of responses relative to the nominal robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.checks.loop_delay import check_delay, delay_warnings, delays, undelayed
from flexros.identify.frf.checks.nominal_level import nominal_diagonal
from flexros.identify.frf.positions import estimate_responses
from flexros.logs.time_series import Log
from flexros.robot import load_robot
from tests.identify.frf.checks.test_joint_pairing import POSES, measured
from tests.identify.frf.checks.test_nominal_level import answering, wrong
from tests.identify.frf.recorded_experiment import Recorded

NAMES = ("motor_1", "motor_2")


def with_late_commands(log: Log, samples: int) -> Log:
    """Shift the commands of a log to later samples."""
    commands = log.joint_commands
    assert commands is not None
    assert commands.effort is not None
    return replace(log, joint_commands=replace(commands, effort=np.roll(commands.effort, samples, axis=0)))


def told(log: Log, recorded: Recorded) -> list[str]:
    """List the warnings about delays."""
    warnings = estimate_responses(log, recorded.plan, robot=recorded.robot)[0].warnings
    return [warning for warning in warnings if "time_offset in the mapping file" in warning]


@pytest.mark.slow
def test_recorded_log_has_no_delay(recorded: Recorded) -> None:
    assert told(recorded.log, recorded) == []


def test_commands_two_samples_early_are_warned_of(recorded: Recorded) -> None:
    assert told(with_late_commands(recorded.log, -2), recorded) == [
        "motor_1, motor_2: the torque leads the motion by 1 ms more than the delay of the model says; give time_offset "
        "in the mapping file or delay in the robot file"
    ]


def test_commands_two_samples_late_are_warned_of(recorded: Recorded) -> None:
    (warning,) = told(with_late_commands(recorded.log, 2), recorded)
    assert "the torque is stamped 1 ms too late against the motion" in warning


def test_delay_that_the_model_knows_is_none(recorded: Recorded) -> None:
    delayed = replace(recorded, robot=recorded.robot.with_values({"delay": 1e-3}))
    assert told(with_late_commands(recorded.log, -2), delayed) == []


def test_long_delay_is_refused(recorded: Recorded) -> None:
    with pytest.raises(
        InputError,
        match=r"position 1: motor_1, motor_2: the torque leads the motion by 10 ms .*, allowed are 5 ms; give time_",
    ):
        estimate_responses(with_late_commands(recorded.log, -20), recorded.plan, robot=recorded.robot)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1 / 3, 3.0])
def test_wrong_springs_are_no_delay(factor: float) -> None:
    robot = load_robot("six_axis")
    found = []
    for pose in POSES:
        mine = answering(measured(robot, pose), wrong(robot, factor))
        found.append(delays(mine, nominal_diagonal(mine, robot)))
        check_delay(found[-1], mine.output_names, "position 1")
    assert delay_warnings(np.array(found), mine.output_names, mine.sample_time) == []


def test_delay_of_a_single_motor_is_warned_of() -> None:
    found = np.array([[[1e-3, 0.0], [1e-5, 1e-5]]])
    (warning,) = delay_warnings(found, NAMES, 5e-4)
    assert warning.startswith("motor_1: the torque leads the motion by 1 ms")
    assert delay_warnings(found * [[1.0], [40.0]], NAMES, 5e-4) == []


def test_delays_are_taken_off_where_they_stand_out() -> None:
    frequency, found = np.array([10.0, 50.0]), np.array([[2e-3, 1e-3], [1e-5, 1e-3]])
    late = np.exp(-2j * np.pi * frequency[:, None] * [2e-3, 1e-3])[:, None, :] * np.ones((2, 2, 2))
    back = undelayed(late, frequency, found)
    np.testing.assert_allclose(back[:, :, 0], 1.0, atol=1e-12)
    np.testing.assert_allclose(back[:, :, 1], late[:, :, 1])
