"""Identifiability limits of a log: effects that its signals cannot show, independent of the fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.record.quantization import Quantization
    from flexros.record.record import Record
    from flexros.robot import Robot

TESTED = 0.6
"""Share of the torque limit below which a motor was not tested under load [1]."""
HIGHEST = 0.4
"""Frequency over the sampling rate up to which a log is informative [1]."""


def identifiability_limits(record: Record, robot: Robot, quantizations: Sequence[Quantization] = ()) -> tuple[str, ...]:
    """State what the signals of a log cannot show, a sentence each.

    Args:
        record: The log.
        robot: The nominal robot.
        quantizations: Encoders whose rounding counts in their noise.
    """
    limits = []
    if record.tool is None:
        limits.append(
            "The tool was not measured: errors of lengths and angles of the arm (kinematic_error) do not show, and the "
            "motion behind the last motor is known through the motors only."
        )
    if record.command is not None:
        limits.append(
            "The log has position commands and no torque: gains of the servos, torque constants and inertias are known "
            "relative to what does not scale with them (gravity, known masses), and the damping of a servo that "
            "follows no speed is part of the viscous friction."
        )
    elif not record.measured_torque:
        limits.append(
            "The torque is the commanded one: a wrong torque constant differs from a wrong inertia only through what "
            "does not scale with torque (springs, dampers, friction, gravity)."
        )
    if record.imported and record.noted is not None:
        limits.append(
            f"The torques were noted with the positions: when in its sample of {record.sample_time * 1e3:.3g} ms each "
            "acted is known as far as the motion shows it, and a delay below half a sample may be that of the recorder."
        )
    largest = np.max(np.abs(record.torque), axis=0)
    if record.prescribed:
        names = ", ".join(robot.joint_names[motor] for motor in record.prescribed)
        limits.append(
            f"The motion of {names} is prescribed as it was measured: nothing is known of what acts there, and of the "
            "bodies behind only what the other motors feel."
        )
    for name, limit, torque, known in zip(robot.joint_names, robot.torque_limits, largest, record.predicted):
        if known and np.isfinite(limit) and torque < TESTED * limit:
            limits.append(
                f"{name} reached at most {100 * torque / limit:.0f} % of its torque limit: saturation above that, and "
                "stiffness at higher loads, are not tested."
            )
    for one in quantizations:
        motor = robot.motors[one.motor]
        share = one.step / robot.encoder_noise[one.motor]
        if not one.coarse:
            limits.append(
                f"The encoder of {motor.name} rounds to steps of {one.step:.3g} {motor.position_unit}, {share:.2g} of "
                "its noise: a property of the sensor, which counts as noise and not as a cause."
            )
    limits.append(
        f"Nothing is known above {HIGHEST / record.sample_time:.0f} Hz, and a lag far below "
        f"{record.sample_time * 1e3:g} ms looks like a delay."
    )
    if not np.any(robot.spec.gravity.value):
        limits.append("Without gravity, errors of masses and of inertias cannot be separated.")
    return tuple(limits)
