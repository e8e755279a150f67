"""Largest torques, speeds, angles and deflections in a log: what the ranges of effects are multiples of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.ranges import Scale
    from flexros.robot import Robot


@dataclass(frozen=True)
class Scales:
    """Largest sizes in a log.

    Attributes:
        sizes: Largest torque, speed, angle and deflection by name of the motor or spring [SI units].
    """

    sizes: Mapping[str, Mapping[str, float]]

    def of(self, scale: Scale, location: str) -> float:
        """Return the size for a place; places that are neither motor nor spring get the largest of all.

        Args:
            scale: Which size.
            location: Where.
        """
        over, _, under = scale.partition("/")
        return self._largest(over, location) / (self._largest(under, location) if under else 1.0)

    def _largest(self, name: str, location: str) -> float:
        sizes = self.sizes.get(name)
        if sizes is None:
            return 1.0
        return sizes.get(location, max(sizes.values()))


def scales_of(robot: Robot, states: FloatArray, torque: FloatArray) -> Scales:
    """Take the sizes from a log and the states that the nominal model predicts for it.

    Args:
        robot: The nominal robot.
        states: Predicted states [q, v], shape (n, n_states).
        torque: Torques of the motors [Nm or N], shape (n, M).
    """
    n, places = robot.n_coordinates, robot.motor_rows
    names = robot.joint_names
    position, speed = states[:, :n], states[:, n : 2 * n]
    torques = {name: max(float(np.abs(torque[:, motor]).max()), 1e-9) for motor, name in enumerate(names)}
    speeds = {name: _largest(speed[:, place]) for name, place in zip(names, places)}
    angles = {name: max(float(np.ptp(position[:, place])), 1e-9) for name, place in zip(names, places)}
    deflections: dict[str, float] = {}
    for index, joint in enumerate(robot.joints):
        value = position[:, index]
        if joint.motor_coordinate is not None:
            value = position[:, robot.n_arm + joint.motor_coordinate] - value
        deflections[joint.name] = _largest(value)
    for motor, name in enumerate(names):
        deflections[name] = deflections[robot.motors[motor].joint.name]
    return Scales({"torque": torques, "speed": speeds, "angle": angles, "deflection": deflections})


def _largest(values: FloatArray) -> float:
    """Return the largest size, but for a thousandth of the samples, and never zero."""
    return max(float(np.quantile(np.abs(values), 0.999)), 1e-9)
