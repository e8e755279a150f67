"""Sizes of the motion from the robot's own numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexros.identify.diagnosis_experiment.scales import scales_of
from flexros.identify.diagnosis_experiment.specification import DiagnosisSpecification
from flexros.robot import load_robot


def test_sizes_on_the_motor_side_are_those_of_the_arm_times_the_gear_ratio() -> None:
    motor, arm = (load_robot(name) for name in ("four_mass", "e12"))
    one, other = (scales_of(DiagnosisSpecification(), robot, robot.home) for robot in (motor, arm))
    np.testing.assert_allclose(one.reach, 220 * other.reach[:1])
    np.testing.assert_allclose(one.speed, 220 * other.speed[:1])


def test_torque_is_three_quarters_of_the_limit_less_what_holds_the_robot() -> None:
    robot = load_robot("four_mass")  # no gravity
    np.testing.assert_allclose(scales_of(DiagnosisSpecification(), robot, robot.home).torque, [15.0])
    robot = load_robot("elbow")
    load = np.abs(robot.holding_torque(robot.equilibrium(robot.home)))
    scales = scales_of(DiagnosisSpecification(), robot, robot.home)
    assert np.all(scales.torque + load < 0.75 * robot.torque_limits)


def test_inertia_is_that_of_the_rigid_robot() -> None:
    robot = load_robot("four_mass")
    np.testing.assert_allclose(scales_of(DiagnosisSpecification(), robot, robot.home).inertia, [[0.047]], rtol=1e-9)


def test_what_is_given_is_taken() -> None:
    robot = load_robot("e12")
    specification = DiagnosisSpecification(reach=(0.1, 0.2), speed=0.7, acceleration=3.0, creep=0.01)
    scales = scales_of(specification, robot, robot.home)
    np.testing.assert_allclose(scales.reach, [0.1, 0.2])
    np.testing.assert_allclose(scales.speed, [0.7, 0.7])
    np.testing.assert_allclose(scales.acceleration, [3.0, 3.0])
    np.testing.assert_allclose(scales.creep, [0.01, 0.01])


def test_smallest_reversal_is_far_above_the_noise_of_the_encoder() -> None:
    robot = load_robot("e12")
    np.testing.assert_allclose(scales_of(DiagnosisSpecification(), robot, robot.home).smallest, 30 * 2e-6)


def test_smallest_reversal_is_above_zero_without_encoder_noise(tmp_path: Path) -> None:
    file = tmp_path / "silent.yaml"
    bodies = "[{mass: 1, directions: {tx: {spring: rigid, motor: {inertia: 1}}}}]"
    file.write_text(f"name: silent\nbodies: {bodies}\noutputs: {{j: {{coordinates: [body_1.tx]}}}}\ncontrolled: j\n")
    robot = load_robot(file)
    assert not robot.encoder_noise.any()
    assert scales_of(DiagnosisSpecification(), robot, robot.home).smallest > 0
