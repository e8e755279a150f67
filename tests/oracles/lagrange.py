"""Slow oracle: equations of motion of a chain from its energies by Lagrange's equation (Moberg 2007, eq. 3.8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

if TYPE_CHECKING:
    from flexros.robot import Robot


def _rotation(axis: str, angle: ca.SX) -> ca.SX:
    c, s = ca.cos(angle), ca.sin(angle)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }[axis]
    return ca.vertcat(*[ca.horzcat(*[ca.SX(entry) for entry in row]) for row in rows])


def arm_energies(robot: Robot, q: ca.SX, v: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return kinetic and gravity energy of the bodies, from positions and rotations in the base frame alone."""
    position, rotation = ca.SX.zeros(3), ca.SX.eye(3)
    kinetic, potential = ca.SX(0), ca.SX(0)
    gravity = ca.DM(robot.spec.gravity.value)
    names = list(robot.arm_names)
    for index, body in enumerate(robot.spec.bodies):
        for axis in body.directions:
            name = f"body_{index + 1}.{axis}"
            if name not in names:
                continue
            coordinate = q[names.index(name)]
            if axis[0] == "t":
                position = position + rotation @ (ca.DM.eye(3)[:, "xyz".index(axis[1])] * coordinate)
            else:
                rotation = rotation @ _rotation(axis[1], coordinate)
        center = position + rotation @ ca.DM(body.center_of_mass.value)
        speed = ca.jtimes(center, q, v)
        spin_matrix = ca.reshape(ca.jtimes(ca.reshape(rotation, 9, 1), q, v), 3, 3) @ rotation.T
        spin = rotation.T @ ca.vertcat(spin_matrix[2, 1], spin_matrix[0, 2], spin_matrix[1, 0])
        kinetic += body.mass.value * ca.dot(speed, speed) / 2 + ca.bilin(ca.DM(body.inertia.matrix()), spin, spin) / 2
        potential -= body.mass.value * ca.dot(gravity, center)
        position = position + rotation @ ca.DM(body.length.value)
    return kinetic, potential


def arm_torque(robot: Robot, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return d/dt dL/dv - dL/dq of the bodies, shape (N,)."""
    qs, vs, accel = (ca.SX.sym(name, robot.n_arm) for name in "qva")
    kinetic, potential = arm_energies(robot, qs, vs)
    momentum = ca.gradient(kinetic, vs)
    torque = ca.jtimes(momentum, vs, accel) + ca.jtimes(momentum, qs, vs) - ca.gradient(kinetic - potential, qs)
    return np.asarray(ca.Function("lagrange", [qs, vs, accel], [torque])(q, v, a)).ravel()
