"""Check of the level of a frequency response against the nominal robot: units, gear ratios."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.record.checks.unit import cause

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, ComplexArray, FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot import Robot

SCALES = (1.0, 1 / 3, 0.6, 1.7, 3.0)
"""Plausible factors on all springs and dampers of the nominal robot, the nominal ones first (chosen)."""

MASS_LIKE = 0.3
"""Largest relative distance of a mass-like response from that of the motor inertia alone (chosen)."""

FEWEST_LINES = 6
"""Fewest mass-like lines that are used (chosen)."""

NOTED_LEVEL = 1.5
"""Factor between measured and nominal level for a warning (chosen)."""

LARGEST_LEVEL = 3.0
"""Factor between measured and nominal level for rejection (chosen)."""


@dataclass(frozen=True, eq=False)
class NominalDiagonal:
    """Responses of every motor to itself, of the nominal robot with springs and dampers times SCALES.

    Attributes:
        response: Torque command -> acceleration, sampled, shape (S, F, M).
        mass_like: Where motor inertia alone determines the response, shape (S, F, M).
    """

    response: ComplexArray
    mass_like: BoolArray


def nominal_diagonal(response: FrequencyResponse, robot: Robot) -> NominalDiagonal:
    """Evaluate the nominal robot at the frequencies and the motor position of a measured response.

    Args:
        response: Measured response with frequencies, sample time and motor position.
        robot: The nominal robot.
    """
    from flexros.identify.frf.sampled import expansion, sampled_hold
    from flexros.robot.linear.positions import linearise_positions  # here, because it loads slowly

    linear = linearise_positions(robot, (), response.motor_position[None])
    hold = sampled_hold(response.frequency, response.sample_time, robot.delay)
    motor_rows = linear.motor_rows
    mass, damping, stiffness = linear.mass[0], linear.damping[0], linear.stiffness[0]
    w = hold.omega[:, None, None]
    drive = np.broadcast_to(np.eye(len(mass))[:, motor_rows], (len(hold.omega), len(mass), len(motor_rows)))
    aliases = np.tensordot(hold.aliases, expansion(linear.mass, linear.damping, linear.stiffness, motor_rows)[0], 1)
    own = np.einsum("fii->fi", aliases)
    inertia = np.diag(np.linalg.inv(mass)[np.ix_(motor_rows, motor_rows)]) * (-hold.gain / hold.omega**2)[:, None]
    answers, like = [], []
    for scale in SCALES:
        Z = np.linalg.solve(scale * stiffness - w**2 * mass + 1j * w * scale * damping, drive)[:, motor_rows]
        direct = hold.gain[:, None] * np.einsum("fii->fi", Z)
        answers.append(direct + own)
        like.append(abs(direct - inertia) <= MASS_LIKE * abs(inertia))
    return NominalDiagonal(np.array(answers), np.array(like))


def levels(response: FrequencyResponse, nominal: NominalDiagonal) -> FloatArray:
    """Return the measured level of every motor over the nominal one at the mass-like lines.

    Of the plausible springs and dampers, those that fit best except for the level are used. With too few mass-like
    lines all lines count. A wrong unit affects all lines: where these have another level, e.g. because noise hides the
    mass-like ones, the one nearer to the nominal robot is returned.

    Args:
        response: Measured response.
        nominal: Nominal response at the same lines.

    Returns:
        Factors, shape (M,).
    """
    own = np.einsum("fii->fi", response.as_quantity("acceleration").response)
    ratio = np.log(np.maximum(abs(own), 1e-300) / abs(nominal.response))
    enough = nominal.mass_like.sum(axis=1) >= FEWEST_LINES
    level, scatter = np.empty((2, len(SCALES), ratio.shape[2]))
    for scale, motor in np.ndindex(*level.shape):
        lines = nominal.mass_like[scale, :, motor] if np.any(enough[:, motor]) else np.ones(len(own), dtype=bool)
        used = ratio[scale, lines, motor] if lines.sum() >= FEWEST_LINES else ratio[scale, :, motor]
        level[scale, motor] = np.median(used)
        scatter[scale, motor] = np.mean(abs(used - level[scale, motor]))
    best, motors = np.argmin(scatter, axis=0), np.arange(level.shape[1])
    mass_like, everywhere = level[best, motors], np.median(ratio, axis=1)[best, motors]
    nearer = np.where(abs(mass_like) < abs(everywhere), mass_like, everywhere)
    return np.asarray(np.exp(np.where(mass_like * everywhere > 0, nearer, 0.0)))


def check_level(factor: FloatArray, names: Sequence[str], robot: Robot, label: str) -> None:
    """Reject a motor whose response has another level than that of the nominal robot.

    Args:
        factor: Measured over nominal level, shape (M,).
        names: Names of the motors, length M.
        robot: The nominal robot.
        label: Name of the record, for messages.

    Raises:
        InputError: A level is off by more than LARGEST_LEVEL; names motor, factor and likely cause.
    """
    size = abs(np.log(factor))
    motor = int(np.argmax(size))
    if size[motor] <= np.log(LARGEST_LEVEL):
        return
    value = float(factor[motor])
    raise InputError(
        f"{label}: the response of {names[motor]} is {value:.3g} times that of robot {robot.name} at the lines where "
        f"motor inertia determines it, allowed is a factor of {LARGEST_LEVEL:g}: {_cause(value, robot, motor)}; "
        "correct the unit, gear ratio or torque constant of this joint in the mapping file, or give the right robot"
    )


def level_warnings(factors: FloatArray, names: Sequence[str], robot: Robot) -> list[str]:
    """Warn of motors whose level differs slightly over all positions.

    Args:
        factors: Measured over nominal level, shape (Q, M).
        names: Names of the motors, length M.
        robot: The nominal robot.

    Returns:
        One sentence per motor.
    """
    middle = np.exp(np.median(np.log(factors), axis=0))
    return [
        f"the response of {name} is {value:.3g} times that of robot {robot.name} where motor inertia determines it; "
        "torque constant, gear ratio or inertia of the motor may be wrong"
        for name, value in zip(names, middle, strict=True)
        if abs(np.log(value)) > np.log(NOTED_LEVEL)
    ]


def _cause(factor: float, robot: Robot, motor: int) -> str:
    """Name the likely cause of a factor between measured and nominal level, as the checks of a record do."""
    known = cause(1 / factor, robot, motor)
    if known:
        return f"it looks like {' or '.join(known)}"
    torque, motion = ("too small", "too large") if factor > 1 else ("too large", "too small")
    return f"the recorded torque is {torque} or the recorded motion {motion}"
