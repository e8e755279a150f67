"""Input of a feedforward method: robot, trajectory and settings, with sampled quantities derived from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.over_rows import over_rows
from flexros.errors import InputError
from flexros.feedforward.tool_geometry import ToolGeometry
from flexros.trajectory.joint_derivatives import OutputDerivatives, joint_derivatives

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.feedforward.specification import FeedforwardSpecification
    from flexros.robot import Robot
    from flexros.trajectory.trajectory import Trajectory

REST_TOLERANCE = 1e-9
"""Largest initial speed and acceleration, relative to the largest along the trajectory, that is taken as rest."""


@dataclass(frozen=True, eq=False)
class FeedforwardProblem:
    """Input of a method.

    Attributes:
        robot: The model that the feedforward uses.
        trajectory: Desired motion, in tool coordinates or in gear coordinates of the rigid arm.
        specification: Settings of the method.
        sample_time: Distance of the sampling instants [s].
        n_samples: Number of instants, the first at 0.
        near: Arm coordinates near which the initial pose is sought [rad or m], shape (N,); None: the robot's home pose.
        laws: Laws of effects that are part of the arm's equations: forces on it, and errors of its kinematics.
        given_output: Desired output in place of that of the trajectory, near it [m or rad], shape (n, n_out).
    """

    robot: Robot
    trajectory: Trajectory
    specification: FeedforwardSpecification
    sample_time: float
    n_samples: int
    near: FloatArray | None = None
    laws: tuple[PlacedLaw, ...] = ()
    given_output: FloatArray | None = None

    @cached_property
    def tool(self) -> ToolGeometry:
        """Kinematics of the tool, with errors by laws."""
        return ToolGeometry.of(self.robot, self.laws)

    @cached_property
    def output(self) -> str:
        """Name of the controlled output: that of the specification, else of the trajectory, else of the robot file."""
        given = None if self.trajectory.joints else self.trajectory.output
        return self.specification.output or given or self.robot.controlled

    @cached_property
    def time(self) -> FloatArray:
        """Sampling instants [s], shape (n,)."""
        return np.arange(self.n_samples, dtype=np.float64) * self.sample_time

    @cached_property
    def desired(self) -> FloatArray:
        """Desired output [m or rad], shape (n, n_out); that of the rigid arm if the trajectory has another output.

        Raises:
            InputError: The trajectory does not start at rest.
        """
        if self.given_output is not None:
            return self.given_output
        motion = self.output_motion(2)
        for order, word in ((1, "speed"), (2, "acceleration")):
            initial, largest = np.abs(motion[order, 0]).max(), np.abs(motion[order]).max()
            if initial > REST_TOLERANCE * max(largest, 1.0):
                raise InputError(
                    f"the trajectory starts with a {word} of {initial:g} (largest component), but feedforward starts "
                    "from rest; give it zero initial speed and acceleration"
                )
        return np.array(motion[0])  # of its own, else the derivatives are held with it

    def output_motion(self, derivatives: int, time: FloatArray | None = None) -> FloatArray:
        """Compute the desired output and its time derivatives.

        Args:
            derivatives: Highest time derivative, 0 to 2.
            time: Times [s], shape (n,); default: the sampling instants.

        Returns:
            Output and derivatives [m or rad, per s^k], shape (derivatives + 1, n, n_out).
        """
        if self.output == self.trajectory.output and not self.trajectory.joints:
            return self.trajectory.evaluate(self.time if time is None else time, derivatives)
        return rigid_kinematics(self.tool, self.output).along(self.gear_motion(derivatives, time))

    def gear_motion(self, derivatives: int, time: FloatArray | None = None) -> FloatArray:
        """Compute the motion of the gears of the rigid arm.

        Args:
            derivatives: Highest time derivative, 0 to 4.
            time: Times [s], shape (n,); default: the sampling instants.

        Returns:
            Gear coordinates and derivatives [rad or m, per s^k], shape (derivatives + 1, n, M).

        Raises:
            InputError: Out of reach or singular; the message names the point of the path.
        """
        if time is not None:
            return self._gear_motion(derivatives, time)
        highest = max(self._sampled, default=-1)
        if highest < derivatives:
            motion = self._gear_motion(derivatives, self.time)
            motion.flags.writeable = False
            self._sampled[derivatives], highest = motion, derivatives
        return self._sampled[highest][: derivatives + 1]

    @cached_property
    def _sampled(self) -> dict[int, FloatArray]:
        """Motion of the gears at the sampling instants, by its highest derivative."""
        return {}

    def _gear_motion(self, derivatives: int, time: FloatArray) -> FloatArray:
        if self.trajectory.joints:
            motion = self.trajectory.evaluate(time, derivatives)
            if motion.shape[2] != self.robot.n_motors:
                raise InputError(
                    f"the trajectory moves {motion.shape[2]} joints, but robot {self.robot.name} has "
                    f"{self.robot.n_motors} motors; give every point one value per motor"
                )
            return motion
        self.require_square(self.trajectory.output)
        near = (self.robot.home if self.near is None else self.near)[list(self.robot.gear_rows)]
        kinematics = rigid_kinematics(self.tool, self.trajectory.output)
        return np.asarray(joint_derivatives(self.trajectory, kinematics, near, time, derivatives))

    def arm_position(self, gears: FloatArray) -> FloatArray:
        """Return arm coordinates (n, N) for gear coordinates (n, M) [rad or m]; elastic directions are zero."""
        arm: FloatArray = self.robot.arm_from_gears(gears)
        return arm

    @cached_property
    def commanded_pose(self) -> FloatArray:
        """Commanded tool pose: that of the rigid arm on the trajectory, for every method, shape (n, 7)."""
        return over_rows(self.tool.pose(), self.arm_position(self.gear_motion(0)[0]))[0]

    @cached_property
    def rigid_start(self) -> FloatArray:
        """Arm coordinates of the rigid arm at the start [rad or m], shape (N,)."""
        return np.asarray(self.arm_position(self.gear_motion(0, np.zeros(1))[0])[0])

    def require_square(self, output: str) -> None:
        """Check that an output has as many components as the robot has motors.

        Raises:
            InputError: The numbers differ, or there is no such output.
        """
        n_out = self.robot.model.output(output).size1_out(0)
        if n_out != self.robot.n_motors:
            raise InputError(
                f"output '{output}' of robot {self.robot.name} has {n_out} components, but its motors can control "
                f"{self.robot.n_motors}, one each; choose another output of the robot"
            )


@lru_cache(maxsize=8)
def rigid_kinematics(tool: ToolGeometry, output: str) -> OutputDerivatives:
    """Return an output as a function of the gear coordinates theta (M,), with elastic directions at zero.

    Args:
        tool: Kinematics of the tool.
        output: Name of an output of its robot.
    """
    theta = ca.SX.sym("theta", tool.robot.n_motors)
    return OutputDerivatives.of(ca.Function("gamma", [theta], [tool.output(output, tool.robot.arm_from_gears(theta))]))
