"""Torques that springs and dampers take from the motors, from the measured motion alone, for robots with springs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.null_fit import predictor_for
from flexros.gap.prediction.compiled_plant import LANES
from flexros.prediction.observer import observer_gain

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.residuals.fit_data import FitData

STEP = 1e-3
"""Step of the differences that make the derivatives to tolerated deviations [standard deviations]."""


@dataclass(frozen=True, eq=False)
class ArmTorque:
    """Torques that springs, dampers and viscous friction of the nominal model take from the motors.

    Attributes:
        torque: The torques [Nm or N], shape (n, M).
        slopes: Their derivatives to the deviations of the tolerated parameters [Nm or N], shape (n, M, n_names); zero
            for those of the motors themselves, which do not change what the arm takes.
    """

    torque: FloatArray
    slopes: FloatArray


def arm_torque(data: FitData, model: RobotWithEffects, tolerance: Tolerance) -> ArmTorque | None:
    """Compute the torques that the arm takes from the motors when these move as measured.

    A predictor of high gain holds the motors to their measured positions, so that the motion of the arm behind its
    springs follows from them and hardly from the torques of the log.

    Args:
        data: Log and weights.
        model: The nominal model.
        tolerance: Parameters of the robot that may deviate.

    Returns:
        The torques; None for a robot without a spring behind every motor.
    """
    robot, record = model.robot, data.record
    if len(robot.flexible_motors) < robot.n_motors:
        return None
    level, noise = data.settings.residuals.starting_level, data.measurement.deviation
    held = replace(data, gain=observer_gain(robot, record.sample_time, level, noise, data.pose))
    predictor = predictor_for(data, model, (), tolerance)
    force = robot.symbolic(tolerance.names).motor_force
    nominal = np.array([robot.parameters[name].value for name in tolerance.names])
    k, N, n = len(tolerance.names), robot.n_arm, robot.n_coordinates
    thetas = np.hstack([np.zeros((k, 1)), STEP * np.eye(k)])
    torques = []
    for begin in range(0, k + 1, LANES):
        group = thetas[:, begin : begin + LANES]
        states = held.predict(predictor, group, record_states=True).states
        assert states is not None
        for lane, theta in enumerate(group.T):
            q, v = states[:, :n, lane].T, states[:, n : 2 * n, lane].T
            parameters = nominal * np.exp(tolerance.logarithms(theta))
            torques.append(-np.asarray(force(q[:N], v[:N], q[N:], v[N:], parameters)).T)
    of_motors = [name.partition(".")[0] in robot.joint_names for name in tolerance.names]
    slopes = [(moved - torques[0]) * (not own) / STEP for moved, own in zip(torques[1:], of_motors, strict=True)]
    return ArmTorque(torques[0], np.stack(slopes, axis=-1) if slopes else np.zeros((*torques[0].shape, 0)))
