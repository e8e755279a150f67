"""Linear model of a robot at equilibrium, for any position of its motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import InputError
from flexros.robot.linear.held_input import held_input

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

SAME = 1e-9
"""Relative difference up to which two linear models count as equal [1] (chosen)."""
TRIED = 0.3
"""Displacement of a motor that tests whether the linear model changes [rad or m] (chosen)."""
LOADS = (0.01, 0.03, 0.1, 0.3, 1.0)
"""Torques in a gear, over the torque limit, at which its stiffness is evaluated (chosen)."""
FARTHEST_BACK = 3
"""Halvings of the way to the home pose in search of an equilibrium, before home itself is used (chosen)."""


@dataclass(frozen=True, eq=False)
class LinearPose:
    """Motion x = [q, q'] from one sample to the next about an equilibrium: x <- F x + B f, motor positions C x.

    Attributes:
        transition: F, shape (2 n, 2 n) for n coordinates.
        push: B, from generalised forces on the coordinates that are held through the sample, shape (2 n, n).
        readout: C, shape (M, 2 n).
        mass: Mass matrix, shape (n, n).
        stiffness: Stiffness matrix, shape (n, n).
        motor: Generalised forces of the motor torques, shape (n, M).
        tool: Generalised forces of a force at the tool, in the base frame, shape (n, 3).
    """

    transition: FloatArray
    push: FloatArray
    readout: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    motor: FloatArray
    tool: FloatArray


class PoseModel:
    """Linear models of a robot, one for each position of its motors.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].

    Attributes:
        home: Positions of the motors in the home pose [rad or m], shape (M,).
    """

    def __init__(self, robot: Robot, sample_time: float) -> None:
        self.robot, self.sample_time = robot, sample_time
        model, n = robot.model, robot.n_coordinates
        q, v = ca.SX.sym("q", n), ca.SX.sym("v", n)
        u, w = ca.SX.sym("u", robot.n_motors), ca.SX.sym("w", 6)
        p = model.parameter_values
        force = model.force(q, v, u, w, p)
        slopes = [-ca.jacobian(force, one) for one in (v, q)] + [ca.jacobian(force, one) for one in (u, w)]
        blocks = [model.mass_matrix(q, p), *slopes, ca.jacobian(model.encoder(q), q)]
        self._rest_at_home = robot.equilibrium()
        self.home = np.array(model.encoder(self._rest_at_home[:n]), dtype=float).ravel()
        self._blocks = ca.Function("blocks", [q, v, u, w], [ca.densify(block) for block in blocks])

    def at(self, motor_position: FloatArray) -> LinearPose:
        """Linearise the robot with its motors held.

        Args:
            motor_position: Positions of the motors [rad or m], shape (M,).
        """
        return self._linear(self._rest(np.asarray(motor_position, dtype=float)))

    def _linear(self, state: FloatArray) -> LinearPose:
        n, T = self.robot.n_coordinates, self.sample_time
        values = self._blocks(state[:n], state[n:], self.robot.holding_torque(state), np.zeros(6))
        mass, damping, stiffness, motor, tool, encoder = (np.array(value, dtype=float) for value in values)
        inverse = np.linalg.inv(mass)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
        B = np.vstack([np.zeros((n, n)), inverse])
        step, entry = held_input(A, B, T)
        readout = np.hstack([encoder, np.zeros_like(encoder)])
        return LinearPose(step, entry, readout, mass, stiffness, motor, tool[:, :3])

    def loaded(self) -> list[LinearPose]:
        """Linearise the robot in its home pose with loaded gears, where load changes their stiffness."""
        found: list[LinearPose] = []
        limits = self.robot.torque_limits
        for motor, row in enumerate(self.robot.motor_rows):
            state = self._rest_at_home.copy()
            stiffness = self._linear(state).stiffness[row, row]
            if not np.isfinite(limits[motor]) or not stiffness > 0 or row == self.robot.gear_rows[motor]:
                continue
            for torque in np.outer((1.0, -1.0), LOADS).ravel() * limits[motor]:
                state[row] = self._rest_at_home[row] + torque / stiffness
                pose = self._linear(state)
                known = [stiffness, *(other.stiffness[row, row] for other in found)]
                if all(abs(pose.stiffness[row, row] / value - 1) > SAME for value in known):
                    found.append(pose)
        return found

    def matters(self) -> tuple[bool, ...]:
        """Return for each motor whether the linear model changes with its position, length M."""
        at_home, found = self.at(self.home), []
        for motor in range(self.robot.n_motors):
            moved = self.home.copy()
            moved[motor] += TRIED
            other = self.at(moved)
            pairs = ((at_home.mass, other.mass), (at_home.stiffness, other.stiffness))
            found.append(any(not np.allclose(a, b, rtol=0.0, atol=SAME * np.abs(a).max()) for a, b in pairs))
        return tuple(found)

    def _rest(self, motor_position: FloatArray) -> FloatArray:
        """Find the equilibrium with the motors held; nearer to home where the springs do not balance gravity."""
        for halved in range(FARTHEST_BACK + 1):
            try:
                return self.robot.equilibrium(motor_position=self.home + (motor_position - self.home) / 2**halved)
            except InputError:
                continue
        return self._rest_at_home
