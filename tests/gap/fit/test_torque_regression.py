"""Friction and inertia that the torques of a log show: recovery of known values by inverse dynamics."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import yaml

from flexros.arrays import FloatArray
from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of
from flexros.gap.fit.torque_regression import regress_torque
from flexros.gap.fit.unknown_numbers import UNCERTAIN, unknown_numbers
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data

T = 0.005
INERTIA, VISCOUS, COULOMB = np.array([0.8, 0.3]), np.array([4.0, 1.5]), np.array([6.0, 2.0])
ARM = """
name: arm
defaults: {source: chosen, tolerance: 0.05}
gravity: [0, 0, -9.81]
bodies:
  - {mass: 6, center_of_mass: [0.2, 0, 0], inertia: {xx: 0.02, yy: 0.1, zz: 0.1}, length: [0.4, 0, 0],
     directions: {ry: {spring: rigid, damper: 0, motor: {inertia: 0}}}}
  - {mass: 3, center_of_mass: [0.15, 0, 0], inertia: {xx: 0.01, yy: 0.04, zz: 0.04}, length: [0.3, 0, 0],
     directions: {ry: {spring: rigid, damper: 0, motor: {inertia: 0}}}}
outputs: {tool: {pose: [x, z]}, joints: {coordinates: [body_1.ry, body_2.ry]}}
controlled: joints
"""


@cache
def arm() -> Robot:
    return robot_from_data(yaml.safe_load(ARM), "arm.yaml")


def motion() -> FloatArray:
    """Return positions, speeds and accelerations of 20 s, shape (3, n, 2)."""
    time = T * np.arange(4000)
    result = np.zeros((3, len(time), 2))
    for motor, lines in enumerate((((0.13, 0.5, 0.0), (0.31, 0.3, 1.0)), ((0.21, 0.6, 2.0), (0.47, 0.2, 0.5)))):
        for frequency, size, phase in lines:
            w = 2 * np.pi * frequency
            for order in range(3):
                result[order, :, motor] += size * w**order * np.sin(w * time + phase + order * np.pi / 2)
    return result


@cache
def record(simulated: bool = False) -> Record:
    q, v, a = motion()
    model = arm().model
    rigid = np.array([np.ravel(model.arm_inverse_dynamics(*row, model.parameter_values)) for row in zip(q, v, a)])
    torque = rigid + INERTIA * a + VISCOUS * v + COULOMB * np.sign(v)
    noise = 1e-6 * np.random.default_rng(5).standard_normal(q.shape)
    held = 0.5 * (torque + np.vstack([torque[1:], torque[-1:]]))
    valid = np.ones(len(q), dtype=bool)
    return Record("log", T, q + noise, held, valid, measured_torque=True, simulated=simulated)


def test_friction_and_inertia_of_all_motors_are_found_at_once() -> None:
    found = regress_torque(record(), arm(), tolerance_of(arm(), {}))
    assert found is not None
    np.testing.assert_allclose(found.inertia, INERTIA, rtol=0.03)
    np.testing.assert_allclose(found.viscous_friction, VISCOUS, rtol=0.03)
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.03)
    assert np.all(found.left < 0.1)


def test_a_body_that_is_heavier_within_tolerance_is_a_deviation_not_friction() -> None:
    light = arm().with_values({"body_2.mass": 3 / 1.1})
    found = regress_torque(record(), light, Tolerance(("body_2.mass",), (0.05,)))
    assert found is not None
    assert found.deviations[0] == pytest.approx(np.log(1.1) / 0.05, rel=0.1)
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.05)


def test_a_log_without_motion_shows_nothing() -> None:
    still = Record("still", T, np.zeros((4000, 2)), np.ones((4000, 2)), np.ones(4000, dtype=bool))
    assert regress_torque(still, arm(), Tolerance()) is None


def test_inertias_that_a_robot_file_lacks_are_estimated_and_uncertain() -> None:
    model = RobotWithEffects(arm(), ())
    unknown = unknown_numbers(record(), model, tolerance_of(arm(), {}))
    np.testing.assert_allclose(list(unknown.inertias.values()), INERTIA, rtol=0.03)
    robot = unknown.given_to(model).robot
    assert robot.parameters["motor_2.inertia"].value == pytest.approx(0.3, rel=0.03)
    tolerance = unknown.tolerated(tolerance_of(robot, {}))
    deviations = dict(zip(tolerance.names, tolerance.deviations))
    assert deviations["motor_1.inertia"] == UNCERTAIN
    assert deviations["body_1.mass"] == 0.05


def test_inertias_that_are_given_stay() -> None:
    given = RobotWithEffects(arm().with_values({"motor_1.inertia": 0.1, "motor_2.inertia": 0.2}), ())
    assert not unknown_numbers(record(), given, Tolerance()).inertias
    assert not unknown_numbers(record(simulated=True), RobotWithEffects(arm(), ()), Tolerance()).inertias
