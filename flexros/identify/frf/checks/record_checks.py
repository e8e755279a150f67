"""Checks for silent FRF errors (joint order, sign, unit, delay, aliasing), before and after estimation."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.checks.joint_pairing import check_order, check_pairing, check_tracking
from flexros.identify.frf.checks.joint_signs import check_signs
from flexros.identify.frf.checks.loop_delay import check_delay, delay_warnings, delays, undelayed
from flexros.identify.frf.checks.nominal_level import check_level, level_warnings, levels, nominal_diagonal
from flexros.identify.frf.checks.record_levels import (
    check_aliasing,
    check_certainty,
    check_periods,
    check_reference,
    check_saturation,
)
from flexros.identify.frf.checks.settling import check_settled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.identify.frf.estimate.period_spectra import PeriodSpectra
    from flexros.identify.frf.experiments import Experiments
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot import Robot

# Detected while the log is aligned with its plan (record_timing, aligned_log): too short a log, missing periods
# at its end, gaps, repeated stamps, unequal rates, aliasing by too low a rate, missing topics and joints;
# then joint positions that differ from the plan (planned_positions).


def check_record(
    experiments: Experiments,
    spectra: PeriodSpectra | None,
    torque_limits: FloatArray | None = None,
    drift_degree: int = 2,
) -> list[str]:
    """Check samples before the estimate.

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
        check_tracking(spectra.at(experiments.excited), experiments.output_names, experiments.label)
        warnings = check_settled(experiments, drift_degree)
    return [*warnings, *check_saturation(experiments, torque_limits), *check_aliasing(experiments)]


def check_result(response: FrequencyResponse, label: str, robot: Robot | None = None) -> list[str]:
    """Check a response by itself and against the nominal robot.

    Args:
        response: The estimate.
        label: Name of the record, for messages.
        robot: The nominal robot; None where it is not known.

    Returns:
        Warnings: the response stays usable.

    Raises:
        InputError: Swapped or inverted joints, another level or delay than the model's, or nothing but noise.
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
        _check_against(response, robot, label)
    return warnings


def _check_against(response: FrequencyResponse, robot: Robot, label: str) -> None:
    """Reject a response that no springs and dampers of the nominal robot explain."""
    check_order(response, robot, label)
    if not _comparable(response, robot):
        return
    nominal = nominal_diagonal(response, robot)
    check_level(levels(response, nominal), response.output_names, robot, label)
    delay = delays(response, nominal)
    check_delay(delay, response.output_names, label)
    in_time = undelayed(response.response, response.frequency, delay)
    check_signs(replace(response, response=in_time), robot, label)


def model_warnings(responses: Sequence[FrequencyResponse], robot: Robot | None) -> list[str]:
    """Compare the level and the delay of the responses of all positions with the nominal robot.

    Args:
        responses: Estimates of the same motors.
        robot: The nominal robot; None where it is not known.

    Returns:
        Warnings: the responses stay usable.
    """
    comparable = [] if robot is None else [response for response in responses if _comparable(response, robot)]
    if robot is None or not comparable:
        return []
    pairs = [(response, nominal_diagonal(response, robot)) for response in comparable]
    names = comparable[0].output_names
    return [
        *level_warnings(np.array([levels(*pair) for pair in pairs]), names, robot),
        *delay_warnings(np.array([delays(*pair) for pair in pairs]), names, comparable[0].sample_time),
    ]


def _comparable(response: FrequencyResponse, robot: Robot) -> bool:
    """Return whether the response has the motors of the robot and their position."""
    fits = response.response.shape[1:] == (robot.n_motors, robot.n_motors)
    return fits and bool(np.all(np.isfinite(response.motor_position)))
