"""What a motion along a path asks of the motors, and what they can give."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.trajectory.path import AbstractPath
    from flexros.trajectory.trajectory import Move


@dataclass(frozen=True, eq=False)
class PathDynamics:
    """Motor torques of a rigid arm on a path, at grid points of the share sigma of the path, from 0 to 1.

    A motion sigma(t) needs the torques

        tau = inertia sigma'' + centrifugal sigma'^2 + viscous sigma' + static,    lower <= tau <= upper,

    and moves the gears with slope sigma', below `speed_limit` in magnitude.

    Attributes:
        grid: Shares of the path, increasing from 0 to 1, shape (n,).
        slope: Derivative of the gear positions with respect to sigma [rad or m], shape (n, M).
        inertia: [Nm s^2 or N s^2], shape (n, M).
        centrifugal: [Nm s^2 or N s^2], shape (n, M).
        viscous: [Nm s or N s], shape (n, M).
        static: Torque at rest [Nm or N], shape (n, M).
        lower: Least torque [Nm or N], -inf for none, shape (n, M).
        upper: Largest torque [Nm or N], inf for none, shape (n, M).
        speed_limit: Largest speed of each gear [rad/s or m/s], inf for none, shape (M,).
        names: Names of the motors, shape (M,).
        pace_limit: Largest sigma' [1/s], as of a limit along the path, inf for none.
    """

    grid: FloatArray
    slope: FloatArray
    inertia: FloatArray
    centrifugal: FloatArray
    viscous: FloatArray
    static: FloatArray
    lower: FloatArray
    upper: FloatArray
    speed_limit: FloatArray
    names: tuple[str, ...]
    pace_limit: float = np.inf

    @property
    def n_motors(self) -> int:
        """Number of motors M."""
        return len(self.names)

    @property
    def largest_pace(self) -> FloatArray:
        """Largest sigma' that the speed limits allow at each grid point [1/s], shape (n,)."""
        with np.errstate(divide="ignore"):
            by_motor = self.speed_limit / np.abs(self.slope)
        return np.asarray(np.minimum(by_motor.min(axis=1), self.pace_limit))

    def torque(self, pace: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Return the torques at the grid points for sigma' and sigma'' there, each of shape (n,)."""
        return np.asarray(
            self.inertia * acceleration[:, None]
            + self.centrifugal * pace[:, None] ** 2
            + self.viscous * pace[:, None]
            + self.static
        )

    def backwards(self) -> PathDynamics:
        """Return the dynamics of the same path travelled from its end to its start."""
        return replace(
            self,
            grid=1.0 - self.grid[::-1],
            slope=-self.slope[::-1],
            inertia=-self.inertia[::-1],
            centrifugal=self.centrifugal[::-1],
            viscous=-self.viscous[::-1],
            static=self.static[::-1],
            lower=self.lower[::-1],
            upper=self.upper[::-1],
        )


@dataclass(frozen=True, eq=False)
class Demand:
    """What a motion asks of the motors.

    Attributes:
        time: Times [s], from the start of the first move, shape (n,).
        torque: Torques [Nm or N], shape (n, M).
        speed: Speeds of the gears [rad/s or m/s], shape (n, M).
    """

    time: FloatArray
    torque: FloatArray
    speed: FloatArray


def path_grid(points: int) -> FloatArray:
    """Return shares of a path, closer towards both ends, where the motion is slow, shape (points,)."""
    return np.asarray(0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, points)))


class ArmOnPath(Protocol):
    """A robot as the planner of time-optimal motions sees it."""

    def dynamics(self, path: AbstractPath, near: FloatArray | None, points: int) -> PathDynamics:
        """Return the rigid dynamics on a path, with the limits of the robot.

        Args:
            path: Path of the tool or of the gears.
            near: Gear positions near those at the start of the path [rad or m], shape (M,); None: those of the run.
            points: Number of grid points.

        Raises:
            InputError: Out of reach, or singular.
        """

    def end(self, path: AbstractPath, near: FloatArray | None) -> FloatArray:
        """Return the gear positions at the end of a path [rad or m], shape (M,)."""

    def demand(self, moves: Sequence[Move], near: FloatArray | None) -> Demand:
        """Return the torques that the feedforward of the run commands, and the speeds of the gears.

        Args:
            moves: Successive moves.
            near: Gear positions near those at the start of the motion [rad or m], shape (M,); None: those of the run.

        Returns:
            Torques and speeds at the sampling instants.
        """
