"""Initial values, bounds and integration step of the prediction-error search."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, unknown_name
from flexros.identify.axis.gear_law import PARAMETERS
from flexros.identify.axis.linear_initial_values import linear_start, rigid_start
from flexros.identify.graybox.parameter_scale import DECADES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.identify.axis.record import AxisRecord
    from flexros.identify.axis.structure import AxisStructure

BELOW = 0.3
"""Cut-off of the low-pass of the rigid regression, relative to the first antiresonance (chosen)."""

LEAST = 1e-3
"""Smallest initial friction, relative to rms torque (and rms speed), so that it has a logarithm (chosen)."""

FACTOR = 10.0**DECADES
"""Default bounds: this factor above and below the initial value, as in fits of frequency responses."""

WIDE_FACTOR = 1000.0
"""The same for friction and the gear nonlinearity, whose initial values are rough (chosen)."""

_WIDE = ("viscous_friction", "coulomb_friction", "stribeck_friction", "stribeck_speed", "gear_knee", "gear_doubling")


def starting_values(
    record: AxisRecord,
    structure: AxisStructure,
    smoothing: float,
    antiresonances: Sequence[float],
    resonances: Sequence[float],
    given: Mapping[str, float],
) -> dict[str, float]:
    """Carry out the two linear steps, as far as they are needed.

    Args:
        record: Record of the axis.
        structure: Model structure.
        smoothing: Speed over which friction changes sign [rad/s or m/s].
        antiresonances: [Hz]; none where all values are given.
        resonances: [Hz].
        given: Values by name that replace those of the linear steps.

    Returns:
        Values by name, of all parameters except those of the gear nonlinearity.

    Raises:
        InputError: A name is unknown, a value not positive, or a value missing.
    """
    for name, value in given.items():
        if name not in structure.names:
            raise unknown_name("parameter of the axis", name, structure.names, "start")
        if name != "offset" and not value > 0:
            raise InputError(f"start: {name} is {value:g}, but must be above zero; correct it")
    torque, speed = record.rms_torque, record.rms_speed
    begin = {"coulomb_friction": 0.0, "viscous_friction": 0.0, "offset": 0.0}
    begin |= {"stribeck_friction": 0.05 * torque, "stribeck_speed": 0.1 * speed}
    if len(antiresonances) or len(resonances):
        lowest = min(antiresonances, default=0.25 / record.sample_time)
        rigid = rigid_start(record, BELOW * lowest, smoothing)
        begin |= linear_start(structure, rigid, antiresonances, resonances)
    begin |= given
    lacking = [name for name in structure.names if name not in {*begin, *PARAMETERS[structure.gear]}]
    if lacking:
        raise InputError(
            f"there is no initial value for {', '.join(lacking)}; give antiresonances and resonances [Hz] of a "
            "frequency response, or these values in start"
        )
    begin["coulomb_friction"] = max(begin["coulomb_friction"], LEAST * torque)
    begin["viscous_friction"] = max(begin["viscous_friction"], LEAST * torque / speed)
    return {name: begin[name] for name in structure.names if name in begin}


def bounds_around(
    structure: AxisStructure,
    begin: Mapping[str, float],
    given: Mapping[str, tuple[float, float]],
    record: AxisRecord,
) -> dict[str, tuple[float, float]]:
    """Choose bounds of all parameters.

    Args:
        structure: Model structure.
        begin: Initial values.
        given: Bounds by name that replace the default ones; names of other gear laws are skipped.
        record: Record of the axis, whose largest torque bounds the offset.

    Returns:
        Lower and upper bounds by name.

    Raises:
        InputError: A lower bound is not below its upper bound, or not above 0.
    """
    most = float(np.max(np.abs(record.torque)))
    bounds: dict[str, tuple[float, float]] = {}
    for name in structure.names:
        factor = WIDE_FACTOR if name in _WIDE else FACTOR
        bounds[name] = (-most, most) if name == "offset" else (begin[name] / factor, begin[name] * factor)
    for name, (low, high) in given.items():
        if not low < high or (name != "offset" and low <= 0):
            raise InputError(
                f"bounds: {name} has the bounds {low:g} and {high:g}, allowed is a lower bound "
                f"{'' if name == 'offset' else 'above 0 and '}below the upper one; correct them"
            )
    return bounds | {name: pair for name, pair in given.items() if name in bounds}


def short_steps(begin: Mapping[str, float], record: AxisRecord, smoothing: float) -> int:
    """Choose Runge-Kutta steps short enough for the steep friction at standstill, up to three times its initial value.

    Args:
        begin: Initial values.
        record: Record of the axis.
        smoothing: Speed over which friction changes sign [rad/s or m/s].

    Returns:
        Steps in each part of a sample.
    """
    decay = 3 * begin["coulomb_friction"] / (begin["motor_inertia"] * smoothing)
    fastest = 2 * np.sqrt(begin["gear_stiffness"] / min(begin["motor_inertia"], begin["arm_1_inertia"]))
    return max(1, int(np.ceil(max(record.durations) * max(decay / 2, fastest / 0.5))))
