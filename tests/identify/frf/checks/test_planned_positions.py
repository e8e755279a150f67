"""Joints that stand elsewhere than the plan says, each with its likely cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.aligned_log import align
from flexros.identify.frf.checks.planned_positions import check_positions
from tests.identify.frf.recorded_experiment import Recorded, run

pytestmark = pytest.mark.slow


def checked(recorded: Recorded, position: np.ndarray) -> None:
    """Check the log with other measured positions."""
    states = replace(recorded.log.joint_states, position=position)
    aligned = align(replace(recorded.log, joint_states=states), recorded.plan)
    check_positions(aligned, recorded.plan, list(recorded.plan.segments), recorded.robot)


def measured(recorded: Recorded) -> np.ndarray:
    position = recorded.log.joint_states.position
    assert position is not None
    return position.copy()


def test_recorded_positions_pass(recorded: Recorded) -> None:
    checked(recorded, measured(recorded))


@pytest.mark.parametrize(
    "motion",
    [{"kind": "constant_speed", "speed": 0.25}, {"kind": "sine", "speed": 0.6}],
    ids=lambda motion: motion["kind"],
)
def test_slow_motion_is_part_of_the_plan(motion: dict[str, object]) -> None:
    moving = run(positions=[[0.0, 0.3]], slow_motion=motion)
    checked(moving, measured(moving))


def test_swapped_joints_are_named(recorded: Recorded) -> None:
    with pytest.raises(
        InputError,
        match=r"position 1: motor_1 is at 0\.3 rad, the plan says .*: motor_1 is at the position of motor_2",
    ):
        checked(recorded, measured(recorded)[:, ::-1].copy())


def test_offset_of_an_encoder_is_named(recorded: Recorded) -> None:
    with pytest.raises(
        InputError, match=r"position 1: motor_2 is at -0\.5 rad.*offset: the encoder is off by -0\.8 rad"
    ):
        checked(recorded, measured(recorded) + np.array([0.0, -0.8]))


def test_small_offset_passes(recorded: Recorded) -> None:
    checked(recorded, measured(recorded) + np.array([0.05, -0.05]))


@pytest.mark.parametrize(
    ("factor", "cause"),
    [
        (180 / np.pi, "degrees were recorded instead of radians"),
        (np.pi / 180, "radians were converted from degrees"),
        (-1.0, "the direction of the joint is inverted"),
        (3.0, "factor: in all positions it is 3 times the plan"),
    ],
)
def test_unit_is_named(recorded: Recorded, factor: float, cause: str) -> None:
    with pytest.raises(InputError, match=f"motor_2 is at .*{cause}"):
        checked(recorded, measured(recorded) * [1.0, factor])


def test_encoder_that_is_stuck_is_named(recorded: Recorded) -> None:
    position = measured(recorded)
    position[:, 1] = 0.3
    with pytest.raises(InputError, match="position 2: motor_2 is at 0.3 rad, .*its encoder is stuck"):
        checked(recorded, position)


def test_log_of_another_plan_is_named(recorded: Recorded) -> None:
    position = measured(recorded)
    position[: recorded.plan.visits[0].end, 1] -= 0.9
    with pytest.raises(InputError, match=r"differs from position to position; give the scenario "):
        checked(recorded, position)
