"""Values to start from: rigid regression, then masses and springs from the extremes of the frequency response."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.motion_estimate import decimate, decimation, edge, estimate_motion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.identify.one_axis.record import AxisRecord
    from flexros.identify.one_axis.structure import AxisStructure

DAMPING_RATIO = 0.02
"""Relative damping of the springs to start from (chosen)."""


@dataclass(frozen=True)
class RigidStart:
    """Rigid axis with friction.

    Attributes:
        inertia: Inertia of motor and arm together [kg m2 or kg].
        viscous_friction: [Nm s/rad or N s/m].
        coulomb_friction: [Nm or N].
        offset: Constant torque on the motor [Nm or N].
    """

    inertia: float
    viscous_friction: float
    coulomb_friction: float
    offset: float


def rigid_start(record: AxisRecord, cutoff: float, smoothing: float) -> RigidStart:
    """Regress the torque on acceleration, speed and its sign, below the first antiresonance (thesis eq. 4.11 to 4.13).

    Args:
        record: Record of the axis.
        cutoff: Corner of the low-pass for all signals [Hz].
        smoothing: Speed over which friction changes its sign [rad/s or m/s].

    Returns:
        The rigid axis; friction is not below zero.

    Raises:
        InputError: The record is too short, or the motor stands still.
    """
    T = record.sample_time
    motion = estimate_motion(record.position[:, None], T, cutoff)
    if not motion.moving[0]:
        raise InputError(f"{record.label}: the motor stands still but for noise; give a log in which it moves")
    speed, acceleration = motion.velocity[:, 0], motion.acceleration[:, 0]
    time = T * np.arange(len(speed))
    acting = np.interp(time - record.delay - T / 2, time, record.torque)  # held, at those instants
    columns = [acceleration, speed, np.tanh(speed / smoothing), np.ones_like(speed), acting]
    factor = decimation(T, cutoff)
    rows = decimate(np.column_stack(columns), factor)
    rows = rows[edge(factor) // factor : len(rows) - edge(factor) // factor or None]
    inertia, viscous, coulomb, constant = np.linalg.lstsq(rows[:, :4], rows[:, 4], rcond=None)[0]
    if inertia <= 0:
        raise InputError(
            f"{record.label}: the regression below {cutoff:.3g} Hz gives an inertia of {inertia:.3g}, but it must be "
            "positive; check sign and unit of torque and position, or give a log with more acceleration"
        )
    return RigidStart(float(inertia), max(float(viscous), 0.0), max(float(coulomb), 0.0), float(-constant))


def chain_of_masses(
    inertia: float, antiresonances: Sequence[float], resonances: Sequence[float]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Find the row of masses and springs that has given extremes at its first mass: the inverse eigenvalue problem.

    The dynamic stiffness of the motor, with s = (jw)^2, is J s prod(1 + s/r^2) / prod(1 + s/a^2). It is expanded into a
    continued fraction of masses and springs in turn (W. Cauer 1926; for robots Berglund and Hovland 2000, thesis
    4.2.2).

    Args:
        inertia: Sum J of all masses [kg m2 or kg].
        antiresonances: Frequencies at which the motor stands still [Hz], ascending, length n - 1.
        resonances: Frequencies at which it moves most [Hz], ascending, length n - 1.

    Returns:
        Inertias, the motor's first, length n, and stiffnesses between them, length n - 1.

    Raises:
        InputError: The frequencies do not alternate, antiresonance first, as those of masses in a row do.
    """
    a, r = sorted(antiresonances), sorted(resonances)
    order = [frequency for pair in zip(a, r) for frequency in pair]
    if len(a) != len(r) or not a or a[0] <= 0 or any(low >= high for low, high in itertools.pairwise(order)):
        raise InputError(
            f"antiresonances are {list(antiresonances)} Hz and resonances {list(resonances)} Hz, but those of masses "
            "in a row alternate, an antiresonance first: give equally many, each antiresonance below its resonance"
        )
    numerator, denominator = np.array([inertia, 0.0]), np.array([1.0])
    for zero, pole in zip(a, r):
        numerator = np.polymul(numerator, [(2 * np.pi * pole) ** -2, 1.0])
        denominator = np.polymul(denominator, [(2 * np.pi * zero) ** -2, 1.0])
    inertias: list[float] = []
    stiffnesses: list[float] = []
    while True:
        mass = numerator[0] / denominator[0]
        inertias.append(float(mass))
        if len(denominator) == 1:
            return tuple(inertias), tuple(stiffnesses)
        rest = (numerator - mass * np.append(denominator, 0.0))[1:-1]  # its last entry is zero: divided by s
        stiffness = rest[0] / denominator[0]
        stiffnesses.append(float(stiffness))
        # rest s / denominator = 1 / (1/k + 1/next)  =>  next = rest s / (denominator - rest s / k)
        remainder = (denominator - np.append(rest, 0.0) / stiffness)[1:]
        numerator, denominator = np.append(rest, 0.0), remainder


def linear_start(
    structure: AxisStructure, rigid: RigidStart, antiresonances: Sequence[float], resonances: Sequence[float]
) -> dict[str, float]:
    """Put the values of the linear steps together.

    Args:
        structure: What the model is made of.
        rigid: The rigid axis.
        antiresonances: [Hz], one less than masses.
        resonances: [Hz], one less than masses.

    Returns:
        Values of all parameters but those of the gear's nonlinearity and of the Stribeck hump, by name.

    Raises:
        InputError: Wrong number or order of frequencies.
    """
    if len(antiresonances) != structure.masses - 1:
        raise InputError(
            f"{len(antiresonances)} antiresonances are given, but a model of {structure.masses} masses has "
            f"{structure.masses - 1}; give that many, or another number of masses"
        )
    inertias, stiffnesses = chain_of_masses(rigid.inertia, antiresonances, resonances)
    dampings = [2 * DAMPING_RATIO * k / (2 * np.pi * f) for k, f in zip(stiffnesses, sorted(resonances))]
    values = {"motor_inertia": inertias[0], "arm_1_inertia": inertias[1], "gear_stiffness": stiffnesses[0]}
    values |= {"gear_damping": dampings[0], "viscous_friction": rigid.viscous_friction}
    values |= {"coulomb_friction": rigid.coulomb_friction}
    if structure.masses == 3:
        values |= {"arm_2_inertia": inertias[2], "arm_stiffness": stiffnesses[1], "arm_damping": dampings[1]}
    if structure.offset:
        values["offset"] = rigid.offset
    return values
