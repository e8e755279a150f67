"""Errors of the damping of servos."""

from __future__ import annotations

import pytest

from flexros.effects import parse_effect, place_effects
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import Scales
from tests.gap.servo_logs import servo_robot


def test_damping_is_scaled() -> None:
    placed = place_effects(servo_robot(), [parse_effect("servo_damping_error@motor_1:relative=0.5", "test")])
    assert placed.robot.parameters["motor_1.servo_damping"].value == pytest.approx(3.0)


@pytest.mark.parametrize(("feedforward", "sought"), [(0.0, False), (1.0, True)])
def test_it_is_sought_where_it_differs_from_viscous_friction(feedforward: float, sought: bool) -> None:
    names = {one.effect.name for one in list_candidates(servo_robot(feedforward).commanded_by("position"), Scales({}))}
    assert ("servo_damping_error" in names) == sought
    assert "viscous_friction" in names
