"""Whether torque and position of every joint count in the directions of the robot: axes inverted in a log."""

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
"""Gain in mean cosine over the couplings from which a direction is believed to be inverted (chosen)."""

OPPOSITE = -0.5
"""Mean cosine of the phase between measured and nominal response below which a sign is wrong (chosen)."""


def check_signs(response: FrequencyResponse, robot: Robot, label: str) -> None:
    """Refuse joints whose direction is not that of the nominal robot.

    Where torque or position of a joint is inverted, its own response has the opposite sign; where both are, its
    couplings with the other joints fit a robot that is turned the other way there.

    Args:
        response: The response of one position.
        robot: The nominal robot.
        label: What the record is called.

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
    here, turned = _coupling(response, robot), [_coupling(_turned(response, i), robot) for i in range(robot.n_motors)]
    best = int(np.argmax(turned))
    if turned[best] - here > CLEARLY:
        raise InputError(
            f"{label}: the couplings with the other joints fit robot {robot.name} better with the direction of "
            f"{response.output_names[best]} inverted (mean cosine {turned[best]:.2f} instead of {here:.2f}); correct "
            "the signs of its torque and position when importing"
        )


def _turned(response: FrequencyResponse, motor: int) -> FrequencyResponse:
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
