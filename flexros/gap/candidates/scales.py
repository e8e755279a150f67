"""Scales of a log: its largest torques, speeds, angles and deflections, which ranges of effects are multiples of."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import binary_dilation

from flexros.feedforward.rigid_arm import rigid_arm
from flexros.record.missing_samples import bridged_motion, long_holes
from flexros.record.prescribed_motion import without_prescribed
from flexros.record.smoothing import motion_cutoff, smooth_motion

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.ranges import Range, Scale
    from flexros.record.record import Record
    from flexros.robot import Robot

SMALLEST = 1e-9
"""Least size of a scale, for motors that do not move [its unit]."""

SETTLED = 3.0
"""Periods of the corner of a low-pass after which the way through a pause is no longer in it [1] (chosen)."""

LOOKED_AT = 500
"""Positions at which the weight of an arm is looked at (chosen)."""


@dataclass(frozen=True)
class Scales:
    """Largest sizes in a log.

    Attributes:
        sizes: Largest torque, speed, angle and deflection by name of the motor or spring [SI units].
        fastest: Highest frequency that the log shows, half of its rate [Hz].
    """

    sizes: Mapping[str, Mapping[str, float]]
    fastest: float = math.inf

    def of(self, scale: Scale, location: str) -> float:
        """Return the size of a scale at a location; that of all motors where it is neither motor nor spring."""
        over, _, under = scale.partition("/")
        return self._largest(over, location) / (self._largest(under, location) if under else 1.0)

    def shown(self, allowed: Range) -> Range:
        """Return a range of frequencies up to the highest one that the log shows, other ranges as they are.

        Samples show a vibration above half of their rate as a slower one, or, as a part of the inertia that does not
        follow, as another inertia (Shannon 1949).
        """
        if allowed.scale != "frequency" or not allowed.low < self.fastest < allowed.high:
            return allowed
        return replace(allowed, high=self.fastest)

    def _largest(self, name: str, location: str) -> float:
        sizes = self.sizes.get(name)
        if sizes is None:
            return 1.0
        return sizes.get(location, max(sizes.values()))


def scales_of(
    robot: Robot,
    states: FloatArray,
    torque: FloatArray,
    prescribed: Collection[int] = (),
    sample_time: float = 0.0,
) -> Scales:
    """Compute the scales of a log.

    Args:
        robot: The nominal robot.
        states: States [q, v] that the nominal model predicts, shape (n, n_states).
        torque: Torques of the motors [Nm or N], shape (n, M).
        prescribed: Motors whose motion is prescribed, so that their torques say nothing.
        sample_time: Interval of the samples [s]; 0 for no limit of the frequencies that they show.
    """
    n, rows = robot.n_coordinates, list(robot.motor_rows)
    position, speed = states[:, :n], states[:, n : 2 * n]
    deflections: dict[str, float] = {}
    for index, joint in enumerate(robot.joints):
        value = position[:, index]
        if joint.motor_coordinate is not None:
            value = position[:, robot.n_arm + joint.motor_coordinate] - value
        deflections[joint.name] = _largest(value)
    for motor in robot.motors:
        deflections[motor.name] = deflections[motor.joint.name]
    found = _scales(robot, torque, speed[:, rows], position[:, rows], deflections, prescribed)
    return replace(found, fastest=0.5 / sample_time) if sample_time > 0 else found


def scales_of_motors(robot: Robot, record: Record) -> Scales:
    """Compute the scales of a log from the measured motion of its motors alone, without deflections.

    Args:
        robot: The robot.
        record: The log.
    """
    position, cutoff = bridged_motion(record.position, record.valid), motion_cutoff(record.sample_time)
    speed = smooth_motion(position, record.sample_time, cutoff)[1]
    holes = long_holes(record.valid)
    if holes.any():  # the way through a short pause is faster than any motion
        known = ~binary_dilation(holes, iterations=max(1, round(SETTLED / (cutoff * record.sample_time))))
        speed = speed[known] if known.any() else speed
    names = robot.joint_names
    torque, rigid = without_prescribed(record).torque, dict.fromkeys(names, SMALLEST)
    found = _scales(robot, torque, speed, position, rigid, record.prescribed)
    return replace(found, fastest=0.5 / record.sample_time)


def _scales(
    robot: Robot,
    torque: FloatArray,
    speed: FloatArray,
    position: FloatArray,
    deflections: Mapping[str, float],
    prescribed: Collection[int],
) -> Scales:
    """Take the largest torques, speeds and angles of the motors, one column each."""
    names = robot.joint_names
    speeds = {name: _largest(speed[:, motor]) for motor, name in enumerate(names)}
    angles = {name: max(float(np.ptp(position[:, motor])), SMALLEST) for motor, name in enumerate(names)}
    torques = {name: max(float(np.abs(torque[:, motor]).max()), SMALLEST) for motor, name in enumerate(names)}
    driven = [name for motor, name in enumerate(names) if motor not in prescribed]
    free = [name for name in driven if torques[name] <= SMALLEST < min(speeds[name], angles[name])]
    if free:
        moved = _torques_of_motion(robot, position, np.array(list(speeds.values())), np.array(list(angles.values())))
        torques |= {name: max(float(moved[names.index(name)]), SMALLEST) for name in free}
    return Scales({"torque": torques, "speed": speeds, "angle": angles, "deflection": deflections})


def _torques_of_motion(robot: Robot, position: FloatArray, speed: FloatArray, angle: FloatArray) -> FloatArray:
    """Return the torques that a motion takes from motors which have none, as in a swing with drives off, shape (M,).

    They are the largest weight, or inertia J times v^2 / (A / 2) for a swing over the angle A with the largest speed v.

    Args:
        robot: The nominal robot.
        position: Motor positions [rad or m], shape (n, M).
        speed: Their largest speeds, shape (M,).
        angle: Their ranges, shape (M,).
    """
    some = position[:: max(1, len(position) // LOOKED_AT)]
    weight = rigid_arm(robot).inverse_dynamics(np.stack([some, 0 * some, 0 * some])).torque
    state = robot.equilibrium(motor_position=np.median(position, axis=0))
    masses = robot.model.mass_matrix(state[: robot.n_coordinates], robot.model.parameter_values)
    inertia = np.diag(np.asarray(masses, dtype=float))[list(robot.motor_rows)]
    return np.asarray(np.maximum(np.abs(weight).max(axis=0), 2 * inertia * speed**2 / angle))


def _largest(values: FloatArray) -> float:
    """Return the largest size but for a thousandth of the samples."""
    return max(float(np.quantile(np.abs(values), 0.999)), SMALLEST)
