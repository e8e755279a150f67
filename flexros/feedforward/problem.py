"""What a feedforward method works on: robot, trajectory and settings, sampled."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import InputError
from flexros.trajectory.joint_derivatives import joint_derivatives, output_derivatives

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.feedforward.specification import FeedforwardSpecification
    from flexros.robot import Robot
    from flexros.trajectory.trajectory import Trajectory

REST_TOLERANCE = 1e-9
"""Largest initial speed and acceleration, relative to the largest on the way, that still counts as rest."""


@dataclass(frozen=True, eq=False)
class FeedforwardProblem:
    """All that a method may use.

    Attributes:
        robot: The model that the feedforward believes in.
        trajectory: Desired motion, in tool coordinates or in gear coordinates of the rigid arm.
        specification: Settings of the method.
        sample_time: Distance of the sampling instants [s].
        n_samples: Number of instants, the first at 0.
        near: Arm coordinates near which the start pose is sought [rad or m], shape (N,); None: the robot's home pose.
    """

    robot: Robot
    trajectory: Trajectory
    specification: FeedforwardSpecification
    sample_time: float
    n_samples: int
    near: FloatArray | None = None

    @cached_property
    def output(self) -> str:
        """Name of the controlled output."""
        asked, given = self.specification.output, None if self.trajectory.joints else self.trajectory.output
        if asked and given and asked != given:
            raise InputError(
                f"feedforward.output is '{asked}', but the trajectory is given for output '{given}'; make them the same "
                "or leave feedforward.output out"
            )
        name = asked or given or self.robot.controlled
        n_out = self.robot.model.output(name).size1_out(0)
        if n_out != self.robot.n_motors:
            raise InputError(
                f"output '{name}' of robot {self.robot.name} has {n_out} components, but feedforward needs as many as "
                f"there are motors, {self.robot.n_motors}; choose another output of the robot"
            )
        return name

    @cached_property
    def time(self) -> FloatArray:
        """Sampling instants [s], shape (n,)."""
        return np.arange(self.n_samples) * self.sample_time

    @cached_property
    def rigid_kinematics(self) -> ca.Function:
        """Controlled output as a function of the gear coordinates theta (M,), elastic directions at zero."""
        theta = ca.SX.sym("theta", self.robot.n_motors)
        arm = ca.SX.zeros(self.robot.n_arm)
        for number, place in enumerate(self.robot.chain.geared):
            arm[place] = theta[number]
        model = self.robot.model
        return ca.Function("gamma", [theta], [model.output(self.output)(arm, model.parameter_values)])

    @cached_property
    def desired(self) -> FloatArray:
        """Desired output [m or rad], shape (n, n_out); that of the rigid arm where the trajectory moves joints.

        Raises:
            InputError: The trajectory does not start at rest.
        """
        motion = output_derivatives(self.trajectory, self.rigid_kinematics, self.time, 2)
        for order, word in ((1, "speed"), (2, "acceleration")):
            initial, largest = np.abs(motion[order, 0]).max(), np.abs(motion[order]).max()
            if initial > REST_TOLERANCE * max(largest, 1.0):
                raise InputError(
                    f"the trajectory starts with a {word} of {initial:g} (largest component), but feedforward starts from "
                    "rest; let it begin with zero speed and acceleration"
                )
        return np.asarray(motion[0])

    def gear_motion(self, derivatives: int) -> FloatArray:
        """Give the motion of the gears of the rigid arm.

        Args:
            derivatives: Highest time derivative, 0 to 4.

        Returns:
            Gear coordinates and derivatives [rad or m, per s^k], shape (derivatives + 1, n, M).

        Raises:
            InputError: Out of reach or singular; the message names the place.
        """
        near = (self.robot.home if self.near is None else self.near)[list(self.robot.chain.geared)]
        return joint_derivatives(self.trajectory, self.rigid_kinematics, near, self.time, derivatives)

    @cached_property
    def rigid_start(self) -> FloatArray:
        """Arm coordinates of the rigid arm at the start [rad or m], shape (N,)."""
        return self.robot.inverse_kinematics(self.desired[0], near=self.near, output=self.output)
