"""Frequency responses of the log of an identification experiment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.logs.time_series import Log
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class LogResponses:
    """Responses from torque commands to motor accelerations in the positions of an experiment.

    Attributes:
        positions: One response per sufficiently recorded position; none where `reason` is given.
        reason: Why there is none, one sentence; empty otherwise.
    """

    positions: tuple[FrequencyResponse, ...]
    reason: str = ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Findings in the record, each sentence once."""
        return tuple(dict.fromkeys(text for response in self.positions for text in response.warnings))

    def as_dict(self) -> dict[str, Any]:
        """Return a short record for JSON; frequencies in Hz, deviations relative to the magnitude."""
        return {"positions": [position_record(response) for response in self.positions]}


def is_identification(provenance: Mapping[str, Any]) -> bool:
    """Whether the provenance is that of an identification experiment."""
    scenario = provenance.get("scenario")
    return isinstance(scenario, dict) and scenario.get("identification") is not None


def log_responses(log: Log, robot: Robot | None = None) -> LogResponses | None:
    """Estimate the frequency responses of a log where its experiment is known.

    Args:
        log: The log; of one that ends or was stopped before its plan, the complete blocks are used.
        robot: The robot of the run, for checks of torque limits and of the order of joints; None where not known.

    Returns:
        The responses, or the reason why there are none; None for logs that are not of an identification experiment.
    """
    if not is_identification(log.provenance):
        return None
    from flexros.identify.frf.positions import estimate_responses
    from flexros.identify.frf.settings import FrfSettings
    from flexros.scenario.identification_plan import plan_of_log

    try:
        return LogResponses(estimate_responses(log, plan_of_log(log), FrfSettings(partial=True), robot))
    except InputError as error:
        return LogResponses((), str(error))


def relative_deviation(response: FrequencyResponse) -> dict[str, float | None]:
    """Compute the median over frequency of the relative standard deviation of each diagonal element.

    Args:
        response: A measured response.

    Returns:
        The median [1] by output; None where the record does not determine the deviation.
    """
    from flexros.identify.frf.response_noise import response_noise

    noise = response_noise(response)
    if noise is None:
        return dict.fromkeys(response.output_names)
    share = np.sqrt(noise.variance) / np.abs(response.response)
    return {name: float(np.median(share[:, motor, motor])) for motor, name in enumerate(response.output_names)}


def position_record(response: FrequencyResponse) -> dict[str, Any]:
    """Return the summary of one response for JSON.

    Args:
        response: A measured response.

    Returns:
        Position, lines, band [Hz], blocks, periods, relative deviation of the diagonal and warnings.
    """
    return {
        "gears": response.gears.tolist(),
        "lines": len(response.frequency),
        "lowest_hz": float(response.frequency[0]),
        "highest_hz": float(response.frequency[-1]),
        "blocks": response.n_blocks,
        "periods": response.n_periods,
        "relative_std_diagonal": relative_deviation(response),
        "warnings": list(response.warnings),
    }
