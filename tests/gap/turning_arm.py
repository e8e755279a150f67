"""A rigid arm of three joints that moves in space, and logs of it by Pinocchio, whose base may stand at a slant."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin
import yaml

from flexros.arrays import FloatArray
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data
from tests.gap.rigid_arm import T, motion
from tests.oracles.pinocchio_model import build

SECONDS = 12.0
"""Of the logs [s]."""
ROTORS, VISCOUS, COULOMB = np.array([0.9, 0.8, 0.3]), np.array([5.0, 4.0, 1.5]), np.array([4.0, 6.0, 2.0])
TURNING = """
name: turning arm
defaults: {source: chosen, tolerance: 0.03}
gravity: [0, 0, -9.81]
bodies:
  - {mass: 5, center_of_mass: [0, 0, 0.1], inertia: {xx: 0.05, yy: 0.05, zz: 0.03}, length: [0, 0, 0.3],
     directions: {rz: {spring: rigid, damper: 0, motor: {inertia: 0.9}}}}
  - {mass: 6, center_of_mass: [0.2, 0.02, 0], inertia: {xx: 0.02, yy: 0.1, zz: 0.1}, length: [0.4, 0, 0],
     directions: {ry: {spring: rigid, damper: 0, motor: {inertia: 0.8}}}}
  - {mass: 3, center_of_mass: [0.15, 0, 0], inertia: {xx: 0.01, yy: 0.04, zz: 0.04}, length: [0.3, 0, 0],
     directions: {ry: {spring: rigid, damper: 0, motor: {inertia: 0.3}}}}
outputs: {tool: {pose: [x, z]}, joints: {coordinates: [body_1.rz, body_2.ry, body_3.ry]}}
controlled: joints
"""


@cache
def turning_arm(gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)) -> Robot:
    return robot_from_data({**yaml.safe_load(TURNING), "gravity": list(gravity)}, "turning_arm.yaml")


def motion_in_space() -> FloatArray:
    """Return positions, speeds and accelerations, shape (3, n, 3)."""
    w, turns = 0.7, [0.9, 0.63, 0.441]
    others = motion(SECONDS)
    time = T * np.arange(others.shape[1])
    first = [turn * np.sin(w * time + order * np.pi / 2) for order, turn in enumerate(turns)]
    return np.concatenate([np.array(first)[:, :, None], others], axis=2)


def log_of(*, tilt: FloatArray, offset: float = 0.0) -> Record:
    """Return a log of the arm by Pinocchio, with friction.

    Args:
        tilt: Rotation of the base about x and y [rad].
        offset: Of the encoder of motor_2 [rad].
    """
    q, v, a = motion_in_space()
    model = build(turning_arm())
    model.jointPlacements[1] = pin.SE3(pin.exp3(np.array([*tilt, 0.0])), np.zeros(3)) * model.jointPlacements[1]
    data = model.createData()
    torque = np.array([pin.rnea(model, data, *each) for each in zip(q, v, a, strict=True)])
    torque += ROTORS * a + VISCOUS * v + COULOMB * np.sign(v)
    rng = np.random.default_rng(3)
    held = 0.5 * (torque + np.vstack([torque[1:], torque[-1:]])) + 0.05 * rng.standard_normal(q.shape)
    position = q + 1e-6 * rng.standard_normal(q.shape) + np.array([0.0, offset, 0.0])
    return Record("log", T, position, held, np.ones(len(q), dtype=bool), measured_torque=True, imported=True)
