"""Everything that makes a frequency response wrong without showing: each found and named, before and after division."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.joint_pairing import check_order, check_pairing
from flexros.identify.frf.joint_signs import check_signs
from flexros.identify.frf.record_levels import (
    check_aliasing,
    check_certainty,
    check_periods,
    check_reference,
    check_saturation,
)
from flexros.identify.frf.settling import check_settled

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.frf.experiments import Experiments
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.frf.period_spectra import PeriodSpectra
    from flexros.robot import Robot

# Found earlier, while the log is aligned with its plan (record_timing, aligned_log): too short a log, periods missing
# at its end, gaps, repeated stamps, unequal rates, aliasing by too low a rate, missing topics and joints.


def check_record(
    experiments: Experiments,
    spectra: PeriodSpectra | None,
    torque_limits: FloatArray | None = None,
    drift_degree: int = 2,
) -> list[str]:
    """Check samples before they are divided.

    Args:
        experiments: The samples.
        spectra: Their spectra where they are periodic, else None.
        torque_limits: Limits of the inputs [Nm or N], shape (n_u,); None where they are not known.
        drift_degree: Degree of the drift of a slow motion, which is no transient.

    Returns:
        Warnings: the response stays usable.

    Raises:
        InputError: Missing periods, no excitation, or saturated torque: it would be wrong.
    """
    if spectra is None:
        warnings = check_reference(experiments)
    else:
        check_periods(experiments, spectra)
        warnings = check_settled(experiments, drift_degree)
    return [*warnings, *check_saturation(experiments, torque_limits), *check_aliasing(experiments)]


def check_result(response: FrequencyResponse, label: str, robot: Robot | None = None) -> list[str]:
    """Check a response by itself and against the nominal robot.

    Args:
        response: What was estimated.
        label: What the record is called.
        robot: The nominal robot; None where it is not known.

    Returns:
        Warnings: the response stays usable.

    Raises:
        InputError: Swapped or inverted joints, or nothing but noise.
    """
    warnings = check_certainty(response, label)
    check_pairing(response, label)
    if robot is not None and not np.all(np.isfinite(response.motor_position)):
        names = ", ".join(response.output_names)
        return [
            *warnings,
            f"{label}: the motor positions of {names} are not known, because the outputs are no positions; whether "
            f"joints are swapped or inverted was not checked against robot {robot.name}",
        ]
    if robot is not None:
        check_order(response, robot, label)
        check_signs(response, robot, label)
    return warnings
