"""Where fits of servos begin: which effects, and with which numbers."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.checked_log import checked_log
from flexros.gap.search.servos import plan
from flexros.gap.search.servos.plan import begun_of, moved_from_zero
from flexros.gap.settings import ServoStartSettings
from flexros.record.record import Record
from flexros.robot import Robot
from tests.gap.servo_logs import servo_arm, servo_log

BARE = partial(servo_arm, rotors=False)


def record_of(robot: Robot) -> Record:
    return replace(checked_log(servo_log(robot=servo_arm), robot, name="log"), imported=True)


@pytest.mark.parametrize(("arm", "effect"), [(BARE, "rotor_inertia"), (servo_arm, "motor_inertia_error")])
@pytest.mark.parametrize("limited", [True, False])
def test_the_rotor_of_a_servo_is_fitted_also_at_its_limit(arm: Any, effect: str, *, limited: bool) -> None:
    robot = arm().commanded_by("position")
    null: Any = SimpleNamespace(model=RobotWithEffects(robot, ()), data=SimpleNamespace(record=record_of(robot)))
    begun = {one.name for one, _ in begun_of(null, np.array([limited, False]), ServoStartSettings())}
    assert f"{effect}@motor_1" in begun
    assert f"{effect}@motor_2" in begun


def test_friction_rotors_and_delays_move_from_zero_on_and_errors_as_ever() -> None:
    robot = BARE().commanded_by("position")
    null: Any = SimpleNamespace(model=RobotWithEffects(robot, ()), data=SimpleNamespace(record=record_of(robot)))
    begun = begun_of(null, np.array([False, False]), ServoStartSettings())
    moved = {one.name: one.free[0] for one, _ in moved_from_zero(begun, record_of(robot), robot)}
    for name in ("coulomb_friction@motor_1", "rotor_inertia@motor_2", "delay@all"):
        assert moved[name].bounds == (0.0, 1.0)
    inertia = 0.02 * 0.3 + 0.3 * 0.1**2  # of the last link about its joint
    assert moved["rotor_inertia@motor_2"].high == pytest.approx(100 * inertia)
    error = next(one for one, _ in begun if one.name == "servo_stiffness_error@motor_1")
    assert moved[error.name] == error.free[0]


def test_the_rotor_of_a_wrist_may_have_a_thousand_times_the_inertia_of_its_flange(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An arm of six servos: 0.2 kg m2 at a flange of 0.0002, while filters of the commands stood for the rest."""
    robot = BARE().commanded_by("position")
    monkeypatch.setattr(plan, "inertias_of_bodies", lambda *_: {"motor_1": 0.03, "motor_2": 1e-4})
    null: Any = SimpleNamespace(model=RobotWithEffects(robot, ()), data=SimpleNamespace(record=record_of(robot)))
    begun = begun_of(null, np.array([False, False]), ServoStartSettings())
    most = {one.name: one.free[0].high for one, _ in moved_from_zero(begun, record_of(robot), robot)}
    assert most["rotor_inertia@motor_1"] == pytest.approx(3.0)
    assert most["rotor_inertia@motor_2"] == pytest.approx(20.0 / (2 * np.pi * plan.SLOWEST_SERVO) ** 2)
