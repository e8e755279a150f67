"""Frequency response of experiments of any kind, with all checks before and after."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.identify.frf.checks.record_checks import check_record, check_result
from flexros.identify.frf.estimate.nonperiodic import record_response
from flexros.identify.frf.estimate.periodic import periodic_response, spectra_of
from flexros.identify.frf.settings import FrfSettings

if TYPE_CHECKING:
    from flexros.identify.frf.experiments import Experiments
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot import Robot


def frequency_response_of(
    experiments: Experiments, settings: FrfSettings | None = None, robot: Robot | None = None
) -> FrequencyResponse:
    """Estimate the frequency response of experiments at one position.

    Args:
        experiments: The samples, e.g. `Experiments.of(inputs, outputs, sample_time)`.
        settings: Settings; default: periodic estimation for whole periods, else local polynomials.
        robot: The nominal robot: its torque limits and the order of its joints are checked as well.

    Returns:
        The response, in the quantity of the outputs, with warnings.

    Raises:
        InputError: The experiments are too few, too short or not independent, or their response would be wrong.
    """
    chosen = FrfSettings() if settings is None else settings
    limits = None if robot is None else robot.torque_limits
    if chosen.method == "periodic" or (chosen.method == "auto" and experiments.periodic):
        spectra = spectra_of(experiments, chosen)
        warnings = check_record(experiments, spectra, limits, chosen.drift_degree)
        response = periodic_response(experiments, chosen, spectra)
    else:
        warnings = check_record(experiments, None, limits)
        response = record_response(experiments, chosen)
    warnings += check_result(response, experiments.label, robot)
    return replace(response, warnings=tuple(warnings))
