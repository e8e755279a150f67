"""What brakes a motor under a servo is viscous friction, or damping of the loop that is less than in the file."""

from __future__ import annotations

import pytest

from flexros.gap.candidates.candidate import Candidate, list_candidates
from flexros.gap.candidates.scales import Scales
from flexros.gap.search.servos.braking import braking_of
from flexros.robot import Robot
from tests.gap.servo_logs import servo_robot


def candidates(robot: Robot, *, measured: bool = True) -> tuple[Candidate, ...]:
    return list_candidates(robot.commanded_by("position"), Scales({}), measured=measured)


@pytest.mark.parametrize(
    ("measured", "size", "name", "found"),
    [
        (True, 0.4, "viscous_friction", 0.4),
        (True, -0.2, "viscous_friction", -0.2),  # the file has 0.3
        (True, -0.6, "servo_damping_error", -0.3),  # of 2
        (False, -0.2, "servo_damping_error", -0.1),
    ],
)
def test_what_friction_cannot_be_is_less_damping(measured: bool, size: float, name: str, found: float) -> None:
    robot = servo_robot()
    braking = braking_of(candidates(robot, measured=measured), robot)["motor_1"]
    one, value = braking.named(size)
    assert one.effect.name == name
    assert value == pytest.approx(found)


@pytest.mark.parametrize(("measured", "most"), [(True, 0.3 + 0.9 * 2.0), (False, 0.9 * 2.0)])
def test_one_number_of_a_fit_takes_both_away(measured: bool, most: float) -> None:
    robot = servo_robot()
    braking = braking_of(candidates(robot, measured=measured), robot)["motor_1"]
    (free,) = braking.together.free
    assert free.signed
    assert free.negative == pytest.approx(most)


@pytest.mark.parametrize("robot", [servo_robot(feedforward=1.0), servo_robot(known=True)])
def test_damping_that_differs_from_friction_or_is_known_stands_alone(robot: Robot) -> None:
    assert not braking_of(candidates(robot), robot)
