"""Tool position of a robot at rest, with its motors held, under gravity and a load."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.over_rows import over_rows
from flexros.errors import InputError, RunError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.kinematics.record import PoseRecord
    from flexros.identify.kinematics.unknowns import Unknowns
    from flexros.robot import Robot

ITERATIONS = 20
"""Most Newton steps for the equilibrium of a pose."""

TOLERANCE = 1e-12
"""Largest step at which an equilibrium counts as found [rad or m]."""


class Elastostatics:
    """Equilibria and tool positions with exact derivatives by the unknowns.

    The arm rests where springs, gravity g and load m at the tool point balance, with motors held at q_m:

        tau(q_a, q_m) + g(q_a) + J(q_a)^T m gravity = 0,      y = t + R (Gamma(q_a)),

    with t, R the frame of the base in that of the tracker.

    Args:
        robot: The robot, with all zeros stated.
        parameters: Names of its unknown parameters.

    Raises:
        InputError: The robot has no geometry.
    """

    def __init__(self, robot: Robot, parameters: tuple[str, ...]) -> None:
        if robot.spec.tool.linear is not None:
            raise InputError(
                f"robot {robot.name} has no geometry but a linear tool coordinate, so there are no lengths and angles "
                "to identify; give a robot with lengths"
            )
        model, n = robot.symbolic(parameters), robot.n_arm
        q, motors, load = ca.SX.sym("q", n), ca.SX.sym("q_m", robot.n_motors), ca.SX.sym("load")
        p, rest, flexible = ca.SX.sym("p", len(parameters)), ca.SX.zeros(n), list(robot.flexible_motors)
        own = motors[flexible]
        point = model.tool_pose(q, p)[:3]
        gravity = ca.DM([robot.parameters[f"gravity.{axis}"].value for axis in "xyz"])
        force = model.transmission_force(q, rest, own, ca.SX.zeros(len(flexible)), p)
        force -= model.arm_inverse_dynamics(q, rest, rest, p)
        force += ca.jtimes(point, q, load * gravity, True)
        for motor in robot.stiff_motors:
            row = robot.gear_rows[motor]
            force[row] = motors[motor] - q[row]
        self._n_arm, self._gears = n, list(robot.gear_rows)
        stiffness = ca.jacobian(force, q)
        self._newton = ca.Function("newton", [q, motors, load, p], [ca.densify(force), ca.densify(stiffness)])
        by_q, by_p = ca.jacobian(point, q), ca.jacobian(point, p)
        self._slopes = ca.Function(
            "slopes", [q, motors, load, p],
            [ca.densify(part) for part in (point, by_q, by_p, stiffness, ca.jacobian(force, p))], {"cse": True},
        )  # fmt: skip

    def equilibria(self, record: PoseRecord, p: FloatArray) -> FloatArray:
        """Return the arm coordinates at rest in all poses [rad or m], shape (n, N).

        Raises:
            RunError: The springs do not balance gravity and load in one of them.
        """
        n = self._n_arm
        q = np.zeros((len(record), n))
        q[:, self._gears] = record.motor_position
        unbalanced = np.ones(len(record), dtype=bool)
        for _ in range(ITERATIONS):
            force, stiffness = over_rows(self._newton, q, *_given(record, p))
            step = np.linalg.solve(stiffness.reshape(-1, n, n), force.reshape(-1, n, 1))[:, :, 0]
            q[unbalanced] -= step[unbalanced]
            unbalanced &= ~(np.abs(step).max(axis=1) < TOLERANCE)
            if not np.any(unbalanced):
                return q
        pose = int(np.argmax(unbalanced))
        raise RunError(
            f"there is no equilibrium with the motors at {np.round(record.motor_position[pose], 4).tolist()} and a "
            f"load of {record.load[pose]:g} kg"
        )

    def points(self, record: PoseRecord, p: FloatArray, *, slopes: bool = True) -> tuple[FloatArray, FloatArray]:
        """Compute tool points in the frame of the base, and their derivatives by the parameters.

        Args:
            record: Poses; the measured tool is not used.
            p: Values of the parameters, shape (P,).
            slopes: Whether derivatives are computed.

        Returns:
            Points [m], shape (n, 3), and derivatives, shape (n, 3, P).
        """
        n, size = self._n_arm, len(p)
        shapes = (3, n), (3, size), (n, n), (n, size)
        point, *parts = over_rows(self._slopes, self.equilibria(record, p), *_given(record, p))
        if not slopes:
            return point, np.zeros((len(record), 3, size))
        by_q, by_p, stiffness, force_by_p = (part.reshape(-1, *shape) for part, shape in zip(parts, shapes))
        return point, by_p - by_q @ np.linalg.solve(stiffness, force_by_p)


def _given(record: PoseRecord, p: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return motor positions, loads and parameters, a row for each pose."""
    return record.motor_position, record.load[:, None], np.tile(p, (len(record), 1))


@lru_cache(maxsize=4)
def elastostatics(robot: Robot, parameters: tuple[str, ...]) -> Elastostatics:
    """Return the elastostatics of a robot, built once."""
    return Elastostatics(robot, parameters)


def measured_points(unknown: Unknowns, record: PoseRecord, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Predict what the tracker measures, and its derivatives by all unknowns.

    Args:
        unknown: The unknowns.
        record: Poses.
        theta: Deviations, shape (P + 6,).

    Returns:
        Points in the frame of the tracker [m], shape (n, 3), and derivatives, shape (n, 3, P + 6).
    """
    from scipy.spatial.transform import Rotation  # loads slowly

    values = unknown.values(theta)
    points, slopes = elastostatics(unknown.robot, unknown.parameters).points(record, values)
    slopes = slopes * np.where(unknown.logarithmic, values, 1.0)
    frame = theta[len(values) :]

    def turned(vector: FloatArray) -> FloatArray:
        return np.asarray(Rotation.from_rotvec(vector).apply(points))

    h = 1e-6
    by_angle = [(turned(frame[3:] + h * e) - turned(frame[3:] - h * e)) / (2 * h) for e in np.eye(3)]
    by_frame = np.concatenate([np.tile(np.eye(3), (len(record), 1, 1)), np.stack(by_angle, axis=2)], axis=2)
    R = Rotation.from_rotvec(frame[3:]).as_matrix()
    return frame[:3] + turned(frame[3:]), np.concatenate([R @ slopes, by_frame], axis=2)
