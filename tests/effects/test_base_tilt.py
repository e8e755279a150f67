"""Slant of the base."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import yaml

from flexros.arrays import FloatArray
from flexros.effects import RobotWithEffects
from flexros.effects.base_tilt import BaseTilt
from flexros.gap.candidates.candidate import candidate_at
from flexros.gap.candidates.scales import Scales
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.schema import Diagnosis
from flexros.robot import Robot, load_robot, robot_from_data
from tests.gap.diagnosis_logs import settings_of
from tests.gap.rigid_arm import arm
from tests.gap.servo_logs import NOISE, servo_log, servo_robot
from tests.gap.servo_logs import T as SERVO_T
from tests.gap.turning_arm import TURNING, log_of, motion_in_space, turning_arm

SLANTS = (np.array([0.006, -0.015]), np.array([0.2, -0.5]))
"""Rotations of the base about x and y, small and large [rad]."""


def test_gravity_is_turned_against_the_base_and_keeps_its_size() -> None:
    turned = BaseTilt(x=0.1, y=-0.2, z=0.3).changed(turning_arm(), "base")
    gravity = np.array(turned.spec.gravity.value)
    assert np.linalg.norm(gravity) == pytest.approx(9.81)
    np.testing.assert_allclose(gravity, pin.exp3(np.array([0.1, -0.2, 0.3])).T @ [0, 0, -9.81], atol=1e-12)
    differing = {name for name, one in turned.parameters.items() if one.value != turning_arm().parameters[name].value}
    assert differing == {"gravity.x", "gravity.y", "gravity.z"}


def test_an_upright_base_is_as_in_the_robot_file_to_the_last_bit() -> None:
    slanted = turning_arm((1.0, 2.0, -9.3))
    for robot in (turning_arm(), slanted):
        assert tuple(BaseTilt().values(robot, "base").values()) == robot.spec.gravity.value


@pytest.mark.parametrize(
    ("gravity", "axes"),
    [
        ((0.0, 0.0, -9.81), ("x", "y")),
        ((0.0, 0.0, 9.81), ("x", "y")),  # at a ceiling
        ((9.81, 0.0, 0.0), ("y",)),  # at a wall: about the first joint it is an encoder offset
        ((0.3, 0.0, -9.8), ("x", "y")),  # nearly upright: no zero of the first joint turns gravity much
        ((6.0, 0.0, -7.76), ("y",)),  # about x as about the first joint, in what torques show
    ],
)
def test_rotations_are_sought_that_nothing_else_does(
    gravity: tuple[float, float, float], axes: tuple[str, ...]
) -> None:
    assert tuple(BaseTilt().fitted(turning_arm(gravity), "base")) == axes


def test_servos_of_a_rigid_arm_that_moves_in_space_show_it() -> None:
    def sought(robot: Robot) -> bool:
        return BaseTilt().sought_if_measured(robot.commanded_by("position"), "base")

    assert sought(servo_arm())
    assert not sought(servo_robot())  # in a plane, where it is an encoder offset of the first joint
    assert not BaseTilt().sought(servo_arm(), "base")
    assert BaseTilt().locations(turning_arm((0.0, 0.0, 0.0))) == ()


def test_measured_torques_of_a_rigid_arm_show_it_also_beside_what_is_found_later() -> None:
    assert BaseTilt().sought_if_measured(turning_arm(), "base")
    assert not BaseTilt().sought_if_measured(arm(), "base")  # in a plane
    assert not BaseTilt().sought_if_measured(load_robot("elbow"), "base")  # springs blur what weight does


@pytest.mark.parametrize("robot", [arm(), load_robot("elbow")])
def test_no_rotation_is_sought_of_an_arm_in_a_plane(robot: Robot) -> None:
    assert not BaseTilt().fitted(robot, "base")


def test_it_begins_with_slants_about_one_axis_after_the_other() -> None:
    candidate = candidate_at(BaseTilt, "base", turning_arm(), Scales({}))
    assert {tuple(start) for start in candidate.starts()} == {
        (0.0375, 0.0),
        (-0.0375, 0.0),
        (0.0, 0.0375),
        (0.0, -0.0375),
    }


STATED = {"torque": 0.05}
"""Tolerance of the torques [1]: where it is stated, no smaller one is tried in a second search."""


def diagnosed(*, tilt: FloatArray, offset: float = 0.0, tolerance: dict[str, float] | None = None) -> Diagnosis:
    settings = settings_of(
        *("coulomb_friction", "viscous_friction", "torque_bias", "gravity_error", "inertia_error", "encoder_offset"),
        *("payload_error", "motor_inertia_error", "base_tilt"),
    )
    log = log_of(tilt=tilt, offset=offset)
    return diagnose(log, turning_arm(), tolerance=tolerance, settings=settings).diagnosis


@cache
def servo_arm() -> Robot:
    """Give the arm that moves in space rotors and servos of its size."""
    data = yaml.safe_load(TURNING)
    for body, stiffness in zip(data["bodies"], (4000.0, 4000.0, 1500.0), strict=True):
        for direction in body["directions"].values():
            direction["motor"]["servo"] = {"stiffness": stiffness, "damping": 0.04 * stiffness}
    return robot_from_data({**data, "sample_time": SERVO_T, "sensors": {"encoder_noise": NOISE}}, "servo_arm.yaml")


@pytest.mark.slow
@pytest.mark.parametrize("tilted", [True, False])
def test_servos_that_give_way_to_weight_show_a_slant(tilted: bool) -> None:
    """An integral part of a servo had stood for it."""
    friction = [f"coulomb_friction@motor_{k}:level={level}" for k, level in enumerate((4, 6, 2), start=1)]
    slant = ["base_tilt@base:x=0.03,y=-0.06"] if tilted else []
    logs = [servo_log(*friction, *slant, duration=5.0, robot=servo_arm, seed=seed) for seed in (0, 5)]
    fitted, further = (replace(checked_log(log, servo_arm(), name="log"), imported=True) for log in logs)
    settings = settings_of("coulomb_friction", "servo_stiffness_error", "servo_integral", "payload_error", "base_tilt")
    found = diagnose(fitted, RobotWithEffects(servo_arm(), ()), holdout=further, settings=settings).diagnosis
    causes = {f"{one.effect}@{one.location}": one.parameters for one in found.causes}
    assert set(causes) == {f"coulomb_friction@motor_{k}" for k in (1, 2, 3)} | ({"base_tilt@base"} if tilted else set())
    for axis, angle in (("x", 0.03), ("y", -0.06)) if tilted else ():
        number = causes["base_tilt@base"][axis]
        assert number.value == pytest.approx(angle, abs=max(2.5 * number.std, 1e-3))


FRICTION = {f"{law}_friction@motor_{k}" for law in ("coulomb", "viscous") for k in (1, 2, 3)}


@pytest.mark.slow
@pytest.mark.parametrize("tilt", SLANTS)
def test_a_slant_is_found_with_its_angles(tilt: FloatArray) -> None:
    found = diagnosed(tilt=tilt, tolerance=STATED)
    causes = {f"{one.effect}@{one.location}": one.parameters for one in found.causes}
    assert set(causes) == {"base_tilt@base", *FRICTION}
    for axis, angle in zip("xy", tilt, strict=True):
        number = causes["base_tilt@base"][axis]
        assert number.value == pytest.approx(angle, abs=2.5 * number.std)
        assert number.std < 0.005


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [SLANTS[0], np.zeros(2)])
def test_a_slant_is_found_beside_ripples_that_hide_it_at_first(tilt: FloatArray) -> None:
    """A rotor and a body that were twice as heavy to turn, and a bias, had stood for it."""
    log, q = log_of(tilt=tilt), motion_in_space()[0]
    ripple = np.array([0.0, 2.0, 1.0]) * np.sin(21 * q + 0.7)
    log = replace(log, torque=log.torque + 0.5 * (ripple + np.vstack([ripple[1:], ripple[-1:]])))
    settings = settings_of(
        *("coulomb_friction", "viscous_friction", "torque_ripple", "motor_inertia_error", "base_tilt", "torque_bias"),
        *("encoder_offset", "payload_error", "gravity_error", "inertia_error"),
    )
    found = diagnose(log, turning_arm(), tolerance=STATED, settings=settings).diagnosis
    causes = {f"{one.effect}@{one.location}": one.parameters for one in found.causes}
    slant = {"base_tilt@base"} if tilt.any() else set()
    assert set(causes) == {"torque_ripple@motor_2", "torque_ripple@motor_3", *FRICTION, *slant}
    for axis, angle in zip("xy", tilt, strict=True) if slant else ():
        number = causes["base_tilt@base"][axis]
        assert number.value == pytest.approx(angle, abs=max(2.5 * number.std, 3e-4))


@pytest.mark.slow
def test_an_encoder_offset_is_no_slant() -> None:
    found = diagnosed(tilt=np.zeros(2), offset=0.04, tolerance=STATED)
    causes = {f"{one.effect}@{one.location}": one.parameters for one in found.causes}
    assert set(causes) == {"encoder_offset@motor_2", *FRICTION}
    assert causes["encoder_offset@motor_2"]["offset"].value == pytest.approx(0.04, abs=0.004)


@pytest.mark.slow
def test_an_upright_arm_has_neither() -> None:
    found = diagnosed(tilt=np.zeros(2))
    assert {f"{one.effect}@{one.location}" for one in found.causes} == FRICTION
