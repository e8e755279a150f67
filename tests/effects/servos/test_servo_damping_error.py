"""Errors of the damping of servos."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import Scales
from tests.gap.servo_logs import servo_robot


def test_damping_is_scaled() -> None:
    placed = place_effects(servo_robot(), [parse_effect("servo_damping_error@motor_1:relative=0.5", "test")])
    assert placed.robot.parameters["motor_1.servo_damping"].value == pytest.approx(3.0)


@pytest.mark.parametrize(("feedforward", "more"), [(0.0, 0.0), (1.0, 9.0)])
def test_it_is_sought_where_it_differs_from_viscous_friction(feedforward: float, more: float) -> None:
    robot = servo_robot(feedforward).commanded_by("position")
    every = {one.effect.name: one.free[0] for one in list_candidates(robot, Scales({}))}
    free = every["servo_damping_error"]
    assert [float(free.decode(np.array(bound))) for bound in free.bounds] == pytest.approx([-0.9, more])
    assert "viscous_friction" in every


def test_it_is_not_sought_where_gains_are_known() -> None:
    robot = servo_robot(known=True).commanded_by("position")
    assert "servo_damping_error" not in {one.effect.name for one in list_candidates(robot, Scales({}))}
