"""From frequency responses to the result of an identification."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.identify.result import identification_result
from flexros.identify.search import SearchSettings, search

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from distributed import Client

    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.result import ExperimentFacts, IdentificationResult
    from flexros.robot import Robot


def fit_responses(
    robot: Robot,
    responses: Sequence[FrequencyResponse],
    names: Sequence[str],
    settings: SearchSettings | None = None,
    *,
    design: ExperimentDesign | None = None,
    facts: ExperimentFacts | None = None,
    truth: Mapping[str, float] | None = None,
    warnings: Sequence[str] = (),
    provenance: Mapping[str, Any] | None = None,
    client: Client | None = None,
    progress: Callable[[int], None] | None = None,
) -> IdentificationResult:
    """Fit unknown parameters to measured frequency responses and judge the fit.

    Args:
        robot: The nominal robot.
        responses: Measured responses, one per position.
        names: Unknown parameters.
        settings: How to search; default: `SearchSettings()`.
        design: How the positions were chosen, where it is known.
        facts: What the experiment took, where it is known.
        truth: True values (SI) by name, where they are known.
        warnings: What else limits the result, a sentence each.
        provenance: Origin of the data.
        client: Dask client whose workers fit instead of threads of this process.
        progress: Called with the number of fits done.

    Returns:
        The result, see `flexros.identify.report` for its files.

    Raises:
        InputError: Settings, names or responses are not possible.
        RunError: The model cannot be evaluated at any start.
    """
    search_result = search(robot, responses, names, settings or SearchSettings(), client, progress)
    return identification_result(
        search_result.problem,
        search_result.fit,
        search_result.searched,
        design=design,
        facts=facts,
        truth=truth,
        warnings=(*warnings, *search_result.warnings),
        provenance=provenance,
    )
