"""Errors of the feedforward of servos."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.errors import InputError
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import Scales
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import SERVO_EFFECTS, servo_log, servo_robot


def text(share: float) -> str:
    return f"servo_feedforward_error@motor_1:share={share}"


@pytest.mark.parametrize(("nominal", "share"), [(0.0, 0.8), (1.0, -0.4)])
def test_share_adds_to_that_of_the_robot_file(nominal: float, share: float) -> None:
    placed = place_effects(servo_robot(nominal), [parse_effect(text(share), "test")])
    assert placed.robot.parameters["motor_1.servo_feedforward"].value == pytest.approx(nominal + share)


def test_log_with_the_effect_is_that_of_a_servo_with_both_shares() -> None:
    changed, nominal = servo_log(text(-0.4), feedforward=1.0, noise=0.0), servo_log(feedforward=0.6, noise=0.0)
    assert changed.joint_states.position is not None
    assert nominal.joint_states.position is not None
    np.testing.assert_allclose(changed.joint_states.position, nominal.joint_states.position, atol=1e-12)


def test_more_than_the_nominal_share_is_not_taken_away() -> None:
    with pytest.raises(InputError, match=r"-0.6.*feedforward of the servo is 0.5.*at least -0.5"):
        place_effects(servo_robot(0.5), [parse_effect(text(-0.6), "test")])


def test_search_is_above_zero_unless_there_is_a_nominal_share() -> None:
    for nominal, signed in ((0.0, False), (0.5, True)):
        candidates = list_candidates(servo_robot(nominal).commanded_by("position"), Scales({}))
        (free,) = next(one.free for one in candidates if one.effect.name == "servo_feedforward_error")
        assert free.signed == signed
    assert free.bounds[0] * free.high == pytest.approx(-0.5)


@pytest.mark.slow
def test_share_is_found_in_a_log_of_positions() -> None:
    robot = servo_robot()
    log, held = (checked_log(servo_log(text(0.8), seed=seed), robot, name="log") for seed in (0, 5))
    (cause,) = diagnose(log, robot, holdout=held, settings=settings_of(*SERVO_EFFECTS)).diagnosis.causes
    share = cause.parameters["share"]
    assert (cause.effect, cause.location) == ("servo_feedforward_error", "motor_1")
    assert share.std is not None
    assert abs(share.value - 0.8) < 4 * share.std < 0.02
