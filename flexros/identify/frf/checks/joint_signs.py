"""Check for inverted joints by the signs of the frequency response."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.checks.joint_pairing import nominal_response

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot import Robot

CLEARLY = 0.3
"""Gain in mean cosine over the couplings above which a direction is inverted (chosen)."""

OPPOSITE = -0.5
"""Mean cosine of the phase between measured and nominal response below which a sign is wrong (chosen)."""


def check_signs(response: FrequencyResponse, robot: Robot, label: str) -> None:
    """Reject joints whose direction is not that of the nominal robot.

    An inverted torque or position gives the response of the joint to itself the opposite sign. Where both are inverted,
    the couplings with the other joints fit the robot with that joint inverted.

    Args:
        response: The response of one position.
        robot: The nominal robot.
        label: Name of the record, for messages.

    Raises:
        InputError: A joint is inverted; names it.
    """
    if response.response.shape[1:] != (robot.n_motors, robot.n_motors):
        return
    agreement = _agreement(response, robot)
    own = np.diag(agreement)
    if own.min() < OPPOSITE:
        name = response.output_names[int(own.argmin())]
        raise InputError(
            f"{label}: the response of {name} to itself has the sign opposite to robot {robot.name}; torque or "
            "position of this joint is inverted, correct its sign when importing"
        )
    if robot.n_motors < 2:
        return
    current = _coupling(response, robot)
    inverted = [_coupling(_inverted(response, i), robot) for i in range(robot.n_motors)]
    best = int(np.argmax(inverted))
    if inverted[best] - current > CLEARLY:
        raise InputError(
            f"{label}: the couplings with the other joints fit robot {robot.name} better with the direction of "
            f"{response.output_names[best]} inverted (mean cosine {inverted[best]:.2f} instead of {current:.2f}); "
            "correct the signs of its torque and position when importing"
        )


def _inverted(response: FrequencyResponse, motor: int) -> FrequencyResponse:
    """Invert the direction of one joint: torque, position and pose."""
    sign = np.ones(len(response.output_names))
    sign[motor] = -1.0
    return replace(
        response,
        response=response.response * sign[:, None] * sign,
        motor_position=response.motor_position * sign,
    )


def _coupling(response: FrequencyResponse, robot: Robot) -> float:
    """Return the mean cosine over the couplings between different joints."""
    agreement = _agreement(response, robot)
    return float(np.mean(agreement[~np.eye(len(agreement), dtype=bool)]))


def _agreement(response: FrequencyResponse, robot: Robot) -> FloatArray:
    """Return the mean cosine of the phase between measured and nominal response, shape (M, M)."""
    product = response.as_quantity("acceleration").response * np.conj(nominal_response(response, robot))
    return np.asarray(np.mean(product.real / np.maximum(abs(product), 1e-300), axis=0))
