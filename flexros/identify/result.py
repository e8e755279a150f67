"""Unknown parameters of a robot from its frequency responses: the whole fit, and its result."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.identify.graybox.bias import bias_signs
from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.fit import cost_at
from flexros.identify.graybox.identifiability import identifiability
from flexros.identify.graybox.residuals import residual_report
from flexros.identify.graybox.scatter import ScatterLimits, scatter_limits
from flexros.identify.graybox.search import SearchSettings, search

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    import pandas as pd
    import plotly.graph_objects as go
    from distributed import Client

    from flexros.arrays import FloatArray
    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.covariance import ParameterCovariance
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.identifiability import Identifiability
    from flexros.identify.graybox.problem import GrayBoxProblem
    from flexros.identify.graybox.residuals import ResidualReport
    from flexros.robot import Robot

MUCH = 5.0
"""Misfit in standard deviations, rms, above which noise does not limit the result (chosen)."""
SAME_MINIMUM = 1.01
"""Fits whose cost is within this factor of the best one count as the same minimum (chosen)."""


@dataclass(frozen=True)
class ExperimentFacts:
    """Effort of the experiment.

    Attributes:
        robot_time: Time that the robot was at work [s].
        positions: Number of positions.
        blocks: Blocks of experiments in all positions together.
        experiments: Experiments in all.
        periods: Recorded whole periods of each experiment.
        period: Length of a period [s].
        excitation: Kind of the excitation, e.g. "multisine".
        log: Path of the log; empty if not known.
        transport: Transport of the run, "direct" or "ros, composed"; empty if not known.
    """

    robot_time: float
    positions: int
    blocks: int
    experiments: int
    periods: int
    period: float
    excitation: str
    log: str = ""
    transport: str = ""

    @classmethod
    def of(cls, plan: ExperimentPlan, log: str = "", transport: str = "") -> ExperimentFacts:
        """Return the facts of a plan.

        Args:
            plan: The plan of the experiment.
            log: Path of the log.
            transport: Transport of the run.
        """
        specification = plan.specification
        blocks = sum(specification.blocks_per_position)
        return cls(
            robot_time=plan.duration,
            positions=sum(number > 0 for number in specification.blocks_per_position),
            blocks=blocks,
            experiments=blocks * plan.n_motors,
            periods=specification.periods,
            period=plan.period_samples * plan.sample_time,
            excitation=specification.excitation.kind,
            log=log,
            transport=transport,
        )


@dataclass(frozen=True, eq=False, repr=False)
class IdentificationResult:
    """A fit with its covariance, verdicts and residuals.

    Attributes:
        problem: Measured responses, robot with nominal values, unknowns; as of the last fit.
        fit: The last fit, which holds the values.
        searched: Fits from all initial values, in their order; the last fit continued the best. May be empty.
        covariance: Covariance of the parameters.
        identifiability: Verdict per parameter.
        residuals: Residuals of the fitted model.
        design: How the positions were chosen, where they were.
        facts: Effort of the experiment, where it is known.
        truth: True values (SI) by name, where a simulated robot was measured.
        warnings: Limits of the result, one sentence each.
        provenance: Origin of the data.
    """

    problem: GrayBoxProblem
    fit: GrayBoxFit
    searched: tuple[GrayBoxFit, ...]
    covariance: ParameterCovariance
    identifiability: Identifiability
    residuals: ResidualReport
    design: ExperimentDesign | None = None
    facts: ExperimentFacts | None = None
    truth: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @property
    def nominal(self) -> FloatArray:
        """Values of the robot before the identification (SI), shape (P,)."""
        return self.problem.scale.nominal

    @property
    def kept_nominal(self) -> tuple[str, ...]:
        """Parameters whose fitted value is not used: not determined, or on a bound of the search."""
        return self.identifiability.names("not_determined")

    @property
    def settled(self) -> bool:
        """Whether the fit converged within its bounds, so that its misfit is evidence about the robot."""
        return self.fit.converged and not np.any(self.fit.at_bound)

    @cached_property
    def limits(self) -> ScatterLimits:
        """Limits of the misfits that chance explains."""
        return scatter_limits(self.problem, self.fit, self.covariance)

    @property
    def much_missed(self) -> bool:
        """Whether the misfit is many times the uncertainty of the responses: noise does not limit the result."""
        if self.covariance.basis == "residuals":
            return False
        cost, lines = self.covariance.reduced_cost, self.residuals.chi_square
        return cost >= max(self.limits.cost, MUCH**2) or lines >= max(self.limits.chi_square, MUCH**2)

    @cached_property
    def bias_signs(self) -> tuple[str, ...]:
        """Signs of a model-form error that shifts parameters by more than their intervals."""
        return bias_signs(self.problem, self.covariance, self.residuals, self.limits, self.settled)

    @cached_property
    def nominal_cost(self) -> float:
        """Cost of the nominal values, each position linearised at its own rest."""
        return cost_at(self.problem, self.problem.model_at(self.nominal), self.nominal)

    @property
    def same_minimum(self) -> int:
        """Number of initial values whose fit ended in the best minimum."""
        costs = self.start_costs
        return int(np.sum(costs <= SAME_MINIMUM * np.min(costs, initial=np.inf)))

    @property
    def start_costs(self) -> FloatArray:
        """Costs of the fits that did not fail, in ascending order, shape (S,)."""
        costs = np.array([each.cost for each in self.searched])
        return np.sort(costs[np.isfinite(costs)])

    @property
    def robot(self) -> Robot:
        """The robot with the identified values; those that are not determined keep their nominal value."""
        from flexros.identify.graybox.identified_robot import identified_robot

        return identified_robot(self.problem.robot, self.fit, self.covariance, kept=self.kept_nominal)

    def to_pandas(self) -> pd.DataFrame:
        """Return nominal and identified value (SI), 95 % interval and verdict of each parameter."""
        from flexros.identify.report.shown import parameters_frame

        return parameters_frame(self)

    def plot(self, what: str = "parameters") -> go.Figure:
        """Draw the parameters with their intervals, or the responses with those of the model.

        Args:
            what: "parameters" or "responses".

        Raises:
            InputError: Another word.
        """
        from flexros.identify.report.shown import identification_figure

        return identification_figure(self, what)

    def write(self, folder: Path | str) -> None:
        """Write identified.yaml, identification.json and report.html into a folder, made where it is missing.

        Raises:
            InputError: They cannot be written there, or the identified robot is not physical.
        """
        from pathlib import Path

        from flexros.identify.report.files import write_identification

        write_identification(self, Path(folder))

    def __repr__(self) -> str:
        from flexros.identify.report.verdict import verdict

        return f"<Identification of {self.problem.robot.name}: {verdict(self)}>"

    def _repr_html_(self) -> str:
        from flexros.identify.report.shown import identification_html

        return identification_html(self)


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
        settings: Settings of the search; default: `SearchSettings()`.
        design: How the positions were chosen, where it is known.
        facts: Effort of the experiment, where it is known.
        truth: True values (SI) by name, where they are known.
        warnings: Other limits of the result, one sentence each.
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


def identification_result(
    problem: GrayBoxProblem,
    fit: GrayBoxFit,
    searched: Sequence[GrayBoxFit] = (),
    *,
    design: ExperimentDesign | None = None,
    facts: ExperimentFacts | None = None,
    truth: Mapping[str, float] | None = None,
    warnings: Sequence[str] = (),
    provenance: Mapping[str, Any] | None = None,
) -> IdentificationResult:
    """Judge a fit: covariance, identifiability, residuals; warnings of the responses and of the fit are added.

    Args:
        problem: The problem of the last fit.
        fit: The last fit.
        searched: Fits from all initial values before it.
        design: How the positions were chosen.
        facts: Effort of the experiment.
        truth: True values (SI) by name, where they are known.
        warnings: Other limits of the result.
        provenance: Origin of the data.

    Returns:
        The result.
    """
    covariance = parameter_covariance(problem, fit)
    return IdentificationResult(
        problem=problem,
        fit=fit,
        searched=tuple(searched),
        covariance=covariance,
        identifiability=identifiability(problem, fit, covariance),
        residuals=residual_report(problem, fit),
        design=design,
        facts=facts,
        truth={} if truth is None else truth,
        warnings=(*warnings, *_own_warnings(problem, fit)),
        provenance={} if provenance is None else provenance,
    )


def _own_warnings(problem: GrayBoxProblem, fit: GrayBoxFit) -> tuple[str, ...]:
    """Collect the warnings of responses and fit; those that differ in numbers only are listed once."""
    alike: dict[str, list[str]] = {}
    for response in problem.responses:
        for text in dict.fromkeys(response.warnings):
            alike.setdefault(re.sub(r"[\d.]+", "#", text), []).append(text)
    texts = []
    for same in alike.values():
        others = len(set(same)) - 1
        texts.append(same[0] if not others else f"{same[0]} (alike in {others} more position{'s' * (others > 1)})")
    if not fit.converged:
        texts.append(f"The fit did not converge: {fit.message}.")
    bound = [name for name, at in zip(fit.names, fit.at_bound, strict=True) if at]
    if bound:
        texts.append(f"On a bound of the search: {', '.join(bound)}.")
    return tuple(texts)
