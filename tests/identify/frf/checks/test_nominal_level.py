"""Units and gear ratios, from the level of responses relative to the nominal robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.checks.nominal_level import check_level, level_warnings, levels, nominal_diagonal
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.frf.positions import estimate_responses
from flexros.robot import Robot, load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import load_scenario
from tests.identify.frf.checks.test_joint_pairing import POSES, measured
from tests.identify.frf.recorded_experiment import Recorded


def answering(response: FrequencyResponse, robot: Robot) -> FrequencyResponse:
    """Give a response the diagonal of a robot."""
    matrix = np.zeros_like(response.response)
    np.einsum("fii->fi", matrix)[:] = nominal_diagonal(response, robot).response[0]
    return replace(response, response=matrix)


def wrong(robot: Robot, factor: float) -> Robot:
    """Change all springs and dampers, up and down in turn, and the payload by 20 %."""
    names = [name for name in robot.parameters if name.endswith(("stiffness", "damping"))]
    values = {name: robot.parameters[name].value * factor ** (-1) ** i for i, name in enumerate(names)}
    payload = [name for name in robot.parameters if name.endswith(".mass")][-1]
    return robot.with_values({**values, payload: 1.2 * robot.parameters[payload].value})


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1 / 3, 3.0])
@pytest.mark.parametrize("pose", POSES)
def test_wrong_springs_and_payload_are_no_wrong_level(pose: list[float], factor: float) -> None:
    robot = load_robot("six_axis")
    mine = answering(measured(robot, pose), wrong(robot, factor))
    found = levels(mine, nominal_diagonal(mine, robot))
    assert np.max(abs(np.log(found))) < np.log(1.4)
    assert level_warnings(found[None], mine.output_names, robot) == []


def test_torque_of_another_unit_is_refused(recorded: Recorded) -> None:
    commands = recorded.log.joint_commands
    assert commands is not None
    assert commands.effort is not None
    log = replace(recorded.log, joint_commands=replace(commands, effort=commands.effort * [1.0, 0.01]))
    with pytest.raises(
        InputError,
        match=r"position 1: the response of motor_2 is 100 times that of robot e12.*the recorded torque is too small",
    ):
        estimate_responses(log, recorded.plan, robot=recorded.robot)
    assert estimate_responses(log, recorded.plan)


def test_noise_at_the_mass_like_lines_is_no_unit() -> None:
    robot = load_robot("two_mass")
    scenario = load_scenario("identify_two_mass")
    log = closed_loop(Experiment.prepare(scenario))
    (mine,) = estimate_responses(log, plan_of_scenario(scenario), robot=robot)
    nominal = nominal_diagonal(mine, robot)
    drowned = abs(mine.response[-5:, 0, 0] / nominal.response[0, -5:, 0])
    assert np.min(drowned) > 20.0  # the chirp has died out there
    assert abs(np.log(levels(mine, nominal)[0])) < np.log(1.1)


def test_causes_of_a_level_are_named(recorded: Recorded) -> None:
    for factor, cause in (
        (57.0, "looks like positions in degrees"),
        (1e-3, "a unit with milli"),
        (0.1, "torque is too large"),
    ):
        with pytest.raises(InputError, match=f"position 1: the response of motor_1 is .*{cause}"):
            check_level(np.array([factor, 1.0]), ("motor_1", "motor_2"), recorded.robot, "position 1")


def test_level_off_by_two_is_reported(recorded: Recorded) -> None:
    commands = recorded.log.joint_commands
    assert commands is not None
    assert commands.effort is not None
    log = replace(recorded.log, joint_commands=replace(commands, effort=commands.effort * [0.5, 1.0]))
    first, second = estimate_responses(log, recorded.plan, robot=recorded.robot)
    (warning,) = [text for text in first.warnings if "where motor inertia determines it" in text]
    assert warning.startswith("the response of motor_1 is 2 times that of robot e12")
    assert warning in second.warnings
