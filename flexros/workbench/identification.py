"""Frequency responses of logs, and parameters fitted to them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, overload

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.identify.frf.files.netcdf import load_responses, save_responses
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.frf.positions import estimate_responses
from flexros.identify.frf.settings import FrfSettings
from flexros.identify.graybox.search import SearchSettings
from flexros.identify.result import IdentificationResult, fit_responses
from flexros.provenance import versions
from flexros.scenario.identification import unknown_names
from flexros.scenario.identification_plan import plan_of_log, plan_of_scenario
from flexros.scenario.scenario import Scenario, load_scenario
from flexros.workbench.given import log_of, robot_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

    import pandas as pd
    import plotly.graph_objects as go

    from flexros.workbench.given import GivenLog, GivenModel


class FrequencyResponses(Sequence[FrequencyResponse]):
    """Measured frequency responses of the positions of an experiment, one `FrequencyResponse` each.

    Args:
        responses: The responses, at least one.

    Raises:
        InputError: There is none.
    """

    def __init__(self, responses: Sequence[FrequencyResponse]) -> None:
        if not responses:
            raise InputError("no frequency responses were given; give at least one")
        self._responses = tuple(responses)

    @overload
    def __getitem__(self, index: int) -> FrequencyResponse: ...

    @overload
    def __getitem__(self, index: slice) -> FrequencyResponses: ...

    def __getitem__(self, index: int | slice) -> FrequencyResponse | FrequencyResponses:
        if isinstance(index, slice):
            return FrequencyResponses(self._responses[index])
        return self._responses[index]

    def __len__(self) -> int:
        return len(self._responses)

    def __iter__(self) -> Iterator[FrequencyResponse]:
        return iter(self._responses)

    @classmethod
    def load(cls, path: Path | str) -> FrequencyResponses:
        """Read responses from a netCDF file that `save` or `flexros identify frf` wrote.

        Raises:
            InputError: The file cannot be read, or has other content.
        """
        return cls(load_responses(path))

    def save(self, path: Path | str) -> None:
        """Write the responses to a netCDF file, whole or not at all; an existing one is replaced.

        Raises:
            InputError: The file cannot be written.
        """
        save_responses(self._responses, path)

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each position (from 1), line [Hz], output and input, see `FrequencyResponse.to_pandas`."""
        import pandas as pd

        parts = {number: response.to_pandas() for number, response in enumerate(self, 1)}
        return pd.concat(parts, names=["position"])

    def plot(self) -> go.Figure:
        """Draw each pair of input and output with its standard deviation; a menu chooses the position."""
        from flexros.identify.frf.response_picture import response_picture

        return response_picture(self._responses)

    def __repr__(self) -> str:
        return f"<FrequencyResponses of {len(self)} position{'s' * (len(self) != 1)}: {self[0]!r}>"

    def _repr_html_(self) -> str:
        from flexros.analysis.frequency_responses import LogResponses
        from flexros.analysis.report.frequency_responses import response_blocks
        from flexros.report.notebook import notebook_html

        return notebook_html("Frequency responses", response_blocks(LogResponses(self._responses)))


def frequency_responses(
    log: GivenLog,
    *,
    scenario: Scenario | str | Path | None = None,
    model: GivenModel | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FrequencyResponses:
    """Estimate the frequency responses from motor torques to motor accelerations, Y(jw) = G(jw) U(jw).

    Args:
        log: Log of an identification experiment, a run, or its path.
        scenario: Scenario of the experiment; default: the one that the log names.
        model: The robot, for checks of limits and order of joints; default: that of the scenario.
        settings: Choices of the estimation, e.g. {"average": "arithmetic"}, see `FrfSettings`.
        progress: Called with the number of positions done and the number of all.

    Returns:
        A response for each position, with its covariance and levels of nonlinear distortion.

    Raises:
        InputError: The log is not of such an experiment, or lacks signals.
    """
    read = log_of(log)
    if scenario is None:
        plan = plan_of_log(read)
        reference: Any = read.provenance["scenario"]["robot"]
    else:
        chosen = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
        plan, reference = plan_of_scenario(chosen), chosen.robot
    checked = validate(FrfSettings, dict(settings or {}), "settings of the estimation")
    robot = robot_of(reference if model is None else model)
    return FrequencyResponses(estimate_responses(read, plan, checked, robot, progress=progress))


def identify_robot(
    responses: Sequence[FrequencyResponse] | GivenLog,
    model: GivenModel,
    *,
    unknown: Sequence[str] = (),
    estimator: str = "LLS",
    weights: str = "combined",
    starts: int = 20,
    seed: int = 1,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    progress: Callable[[int], None] | None = None,
) -> IdentificationResult:
    """Fit unknown springs, dampers and other parameters to frequency responses (Moberg 2007, Paper A).

    Args:
        responses: Measured responses, or the log of an identification experiment, from which they are estimated.
        model: The nominal robot: built-in name, path of a robot file, or a robot.
        unknown: Names of the unknown parameters, e.g. "body_1.rz.stiffness"; default: those listed in the robot file,
            else all springs and dampers.
        estimator: "LLS" (logarithm), "LLSM" (logarithm of the magnitude) or "NLS".
        weights: Of the last fit: "user", "optimal" or "combined".
        starts: Number of initial values, the first are the nominal ones.
        seed: Seed of the initial values.
        bounds: Lower and upper bound (SI) by name; default: a factor of 10 either way.
        progress: Called with the number of fits done.

    Returns:
        Values with 95 % intervals and verdicts; `robot` is the robot with them, `write` makes its files.

    Raises:
        InputError: Settings, names or responses are not possible.
        RunError: The model cannot be evaluated at any start.
    """
    robot = robot_of(model)
    given = isinstance(responses, Sequence) and not isinstance(responses, str)
    measured = responses if given else frequency_responses(responses, model=robot)  # type: ignore[arg-type]
    settings = SearchSettings(estimator, weights, starts, seed, dict(bounds or {}))
    names = unknown_names(robot, unknown)
    settings.check(robot, names)
    provenance = {"robot": robot.name, "seed": seed, "versions": versions()}
    return fit_responses(robot, tuple(measured), names, settings, provenance=provenance, progress=progress)  # type: ignore[arg-type]
