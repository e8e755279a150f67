"""Other directions of gravity and other zeros of joints, found from torques."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.posture import Motion, Posture, postures
from flexros.record.record import Record
from flexros.record.smoothing import smooth_motion
from flexros.robot import Robot, load_robot
from flexros.robot.parameters import GRAVITY

STEP = 0.02


@pytest.fixture(name="found", scope="module")
def found_fixture() -> Callable[..., tuple[Posture, ...]]:
    six_axis = load_robot("six_axis")
    time = STEP * np.arange(700)
    rates = 0.9 + 0.13 * np.arange(6)
    position = 0.2 + 0.7 * np.sin(np.outer(time, rates) + np.arange(6))
    noise = 1e-5 * np.random.default_rng(0).normal(size=position.shape)

    def found(
        robot: Robot = six_axis, *, sign: float = 1.0, turned: tuple[float, ...] = (), **numbers: float
    ) -> tuple[Posture, ...]:
        """Compare a log of six_axis with other numbers and positions, and with friction, with a robot."""
        added = np.zeros(6)
        added[: len(turned)] = np.radians(turned)
        other = six_axis.with_values(numbers)
        torque = rigid_inverse_dynamics(other, position + added, STEP, 4.0)
        torque += 0.1 * torque.std(axis=0) * np.sign(np.gradient(position, axis=0))
        record = Record("log", STEP, position + noise, sign * torque, np.ones(len(time), dtype=bool))
        smooth = smooth_motion(record.position, STEP, 10.0)
        return postures(Motion(record, robot, record.position, smooth, np.ones(6, dtype=bool), 4.0))

    return found


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 9.81), (9.81, 0.0, 0.0), (0.0, -6.94, -6.94)])
def test_a_base_that_is_mounted_otherwise_is_found(found, gravity) -> None:
    """Under a ceiling, on a wall, and at a slant as a shoulder of a humanoid."""
    best, *others = found(**dict(zip(GRAVITY, gravity, strict=True)))
    mounted = best if not best.turned.any() else others[0]
    assert mounted.gravity == pytest.approx(gravity, abs=0.3)
    assert mounted.carrying.sum() >= 2
    assert mounted.rest < 0.2 < 0.3 < mounted.stated


def test_zeros_elsewhere_are_found(found) -> None:
    best, *_ = found(turned=(0.0, 0.0, 90.0, 0.0, 90.0))
    assert best.turned.tolist()[:3] == [0, 0, 90]
    assert best.turned[4] == 90


def test_a_robot_without_gravity_gets_that_of_the_log(found) -> None:
    robot = load_robot("six_axis").with_values(dict.fromkeys(GRAVITY, 0.0))
    (found_one,) = found(robot)
    assert found_one.gravity == pytest.approx([0, 0, -9.81])


@pytest.mark.parametrize(
    "numbers",
    [
        {},
        {"body_2.mass": 800.0, "body_3.mass": 420.0},
        dict.fromkeys(GRAVITY, 0.0),
        {"gravity.x": 1.0},
    ],
    ids=["as stated", "masses far off", "without weight", "slightly aslant"],
)
def test_no_other_posture_is_found(found, numbers) -> None:
    """Errors of the model are left to the diagnosis, and torques without the weight to their own check."""
    assert not found(**numbers)


def test_torques_of_the_other_sign_are_no_base_upside_down(found) -> None:
    assert not found(sign=-1.0)
