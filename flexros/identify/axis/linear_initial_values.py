"""Initial values: rigid regression, then masses and springs from the resonances of the frequency response."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import butter, sosfiltfilt

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.identify.axis.record import AxisRecord
    from flexros.identify.axis.structure import AxisStructure

DAMPING_RATIO = 0.02
"""Initial relative damping of the springs (chosen)."""

EXPLAINED = 0.5
"""Share of the variance of the torque that a rigid axis must explain at low frequencies (chosen)."""

_ORDER = 4
"""Order of the Butterworth filter, run forwards and backwards (chosen)."""


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
    """Regress torque on acceleration, speed and sign of speed below the first antiresonance (thesis eq. 4.11 to 4.13).

    Args:
        record: Record of the axis.
        cutoff: Cut-off of the low-pass for all signals [Hz].
        smoothing: Speed over which friction changes sign [rad/s or m/s].

    Returns:
        The rigid axis; friction is not negative.

    Raises:
        InputError: The record is too short, or a rigid axis does not explain its torque.
    """
    T = record.sample_time
    sections, settling = butter(_ORDER, 2 * cutoff * T, output="sos"), round(1 / (cutoff * T))
    if len(record.torque) < 4 * settling:
        raise InputError(
            f"{record.label} has {len(record.torque)} samples, but a regression below {cutoff:.3g} Hz needs at least "
            f"{4 * settling}; give a longer log, or initial values for all parameters instead of frequencies"
        )
    position = sosfiltfilt(sections, record.position)
    speed = np.gradient(position, T)
    time = T * np.arange(len(speed))
    acting = np.interp(time - record.delay - T / 2, time, record.torque)  # the held torque at those instants
    columns = [np.gradient(speed, T), speed, np.tanh(speed / smoothing), np.ones_like(speed), acting]
    rows = sosfiltfilt(sections, np.column_stack(columns), axis=0)[settling:-settling]  # all through the same filter
    solution = np.linalg.lstsq(rows[:, :4], rows[:, 4], rcond=None)[0]
    left = 1 - float(np.var(rows[:, 4] - rows[:, :4] @ solution) / max(np.var(rows[:, 4]), np.finfo(float).tiny))
    inertia, viscous, coulomb, constant = (float(value) for value in solution)
    if inertia <= 0 or not left >= EXPLAINED:
        raise InputError(
            f"{record.label}: a rigid axis of inertia {inertia:.3g} explains {100 * left:.3g} % of the torque below "
            f"{cutoff:.3g} Hz, required are a positive inertia and {100 * EXPLAINED:g} %; check joint, sign and unit "
            "of torque and position and the first antiresonance, or give a log with more motion"
        )
    return RigidStart(inertia, max(viscous, 0.0), max(coulomb, 0.0), -constant)


def chain_of_masses(
    inertia: float, antiresonances: Sequence[float], resonances: Sequence[float]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Compute the chain of masses and springs with given antiresonances and resonances of its first mass.

    This is the inverse eigenvalue problem. The dynamic stiffness of the motor, with s = (jw)^2, is
    J s prod(1 + s/r^2) / prod(1 + s/a^2). It is expanded into a continued fraction of masses and springs in turn
    (W. Cauer 1926; for robots Berglund and Hovland 2000, thesis 4.2.2).

    Args:
        inertia: Sum J of all masses [kg m2 or kg].
        antiresonances: Frequencies of zero motor motion [Hz], ascending, length n - 1.
        resonances: Frequencies of largest motor motion [Hz], ascending, length n - 1.

    Returns:
        Inertias, the motor's first, length n, and stiffnesses between them, length n - 1.

    Raises:
        InputError: The frequencies do not alternate, antiresonance first, as those of a chain of masses do.
    """
    a, r = sorted(map(float, antiresonances)), sorted(map(float, resonances))
    order = [frequency for pair in zip(a, r) for frequency in pair]
    if len(a) != len(r) or not a or a[0] <= 0 or any(low >= high for low, high in itertools.pairwise(order)):
        raise InputError(
            f"antiresonances are {a} Hz and resonances {r} Hz, but those of masses "
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
    """Combine the values of the linear steps.

    Args:
        structure: Model structure.
        rigid: The rigid axis.
        antiresonances: [Hz], one less than masses.
        resonances: [Hz], one less than masses.

    Returns:
        Values by name of all parameters except those of the gear nonlinearity and of the Stribeck term.

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
