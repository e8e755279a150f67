"""Scales of a robot's motion, to which the sizes of deviations are drawn in proportion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.validation.blind.plant.plant import BlindRun


@dataclass(frozen=True, eq=False)
class Scales:
    """Largest values in a run of the robot without deviations.

    Attributes:
        robot: The robot.
        duration: Length of the run [s].
        torque: Largest command of each motor [Nm or N], shape (M,).
        speed: Largest speed of each motor [rad/s], shape (M,).
        way: Way of each motor from lowest to highest position [rad], shape (M,).
        middle: Middle of that way [rad], shape (M,).
        deflection: Largest deflection of each arm joint's spring about its mean [rad], shape (N,).
        load: Torque that each motor's gear transmits, rms [Nm or N], shape (M,).
    """

    robot: Robot
    duration: float
    torque: FloatArray
    speed: FloatArray
    way: FloatArray
    middle: FloatArray
    deflection: FloatArray
    load: FloatArray


def scales_of(robot: Robot, run: BlindRun, sample_time: float) -> Scales:
    """Measure a run.

    Args:
        robot: The robot without deviations.
        run: Its run.
        sample_time: Time between two samples [s].

    Returns:
        The scales.
    """
    places, n = list(robot.motor_rows), robot.n_coordinates
    q, v = run.states[:, :n], run.states[:, n:]
    deflection = []
    for index, joint in enumerate(robot.joints):
        own = None if joint.motor_coordinate is None else robot.n_arm + joint.motor_coordinate
        bent = q[:, index] if own is None else q[:, own] - q[:, index]
        deflection.append(float(np.max(np.abs(bent - np.mean(bent)))))
    return Scales(
        robot,
        (len(q) - 1) * sample_time,
        np.max(np.abs(run.command), axis=0),
        np.max(np.abs(v[:, places]), axis=0),
        np.ptp(q[:, places], axis=0),
        (np.max(q[:, places], axis=0) + np.min(q[:, places], axis=0)) / 2,
        np.array(deflection),
        np.sqrt(np.mean(run.command**2, axis=0)),
    )
