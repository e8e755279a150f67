"""One call from samples to a frequency response, whatever the samples are."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.identify.frf.periodic_estimate import periodic_response
from flexros.identify.frf.record_estimate import record_response
from flexros.identify.frf.settings import FrfSettings

if TYPE_CHECKING:
    from flexros.identify.frf.experiments import Experiments
    from flexros.identify.frf.frequency_response import FrequencyResponse


def frequency_response_of(experiments: Experiments, settings: FrfSettings | None = None) -> FrequencyResponse:
    """Estimate the frequency response of experiments at one position.

    Args:
        experiments: The samples, e.g. `Experiments.of(inputs, outputs, sample_time)`.
        settings: How; default: whole periods where the records are, else local polynomials.

    Returns:
        The response, in the quantity of the outputs.

    Raises:
        InputError: The experiments are too few, too short or not independent.
    """
    chosen = FrfSettings() if settings is None else settings
    if chosen.method == "periodic" or (chosen.method == "auto" and experiments.periodic):
        return periodic_response(experiments, chosen)
    return record_response(experiments, chosen)
