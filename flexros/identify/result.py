"""Everything an identification found, for table, JSON and report alike."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.fit import cost_at
from flexros.identify.graybox.identifiability import identifiability
from flexros.identify.graybox.residuals import residual_report
from flexros.identify.report.bias import bias_signs
from flexros.identify.report.own_warnings import own_warnings
from flexros.identify.report.scatter import ScatterLimits, scatter_limits
from flexros.identify.report.verdict import advice, covariance_text, verdict
from flexros.identify.report.words import known_ends

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.graybox.covariance import ParameterCovariance
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.identifiability import Identifiability
    from flexros.identify.graybox.problem import GrayBoxProblem
    from flexros.identify.graybox.residuals import ResidualReport

MUCH = 5.0
"""Misfit in standard deviations, rms, from which noise is not what limits the result (chosen)."""
SAME_MINIMUM = 1.01
"""Fits whose cost is within this factor of the best one count as the same minimum (chosen)."""


@dataclass(frozen=True)
class ExperimentFacts:
    """What the experiment took.

    Attributes:
        robot_time: Time that the robot was at work [s].
        positions: Number of positions.
        blocks: Blocks of experiments in all positions together.
        experiments: Experiments in all.
        periods: Recorded whole periods of each experiment.
        period: Length of a period [s].
        excitation: Kind of the excitation, e.g. "multisine".
        log: Where the log lies; empty if not known.
        transport: How it ran, "direct" or "ros, composed"; empty if not known.
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
        """Read the facts off a plan.

        Args:
            plan: The plan of the experiment.
            log: Where the log lies.
            transport: How it ran.
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


@dataclass(frozen=True, eq=False)
class IdentificationResult:
    """An identification with all that is told about it.

    Attributes:
        problem: Measured responses, robot with nominal values, unknowns; as of the last fit.
        fit: The fit that counts.
        searched: Fits from all starts, from which the last fit began, in the order of the starts; may be empty.
        covariance: Covariance of the parameters.
        identifiability: Verdict per parameter.
        residuals: What the fitted model leaves unexplained.
        design: How the positions were chosen, where they were.
        facts: What the experiment took, where it is known.
        truth: Values of the robot that was measured (SI), where it was a simulated one and they are known.
        warnings: What limits the result, one sentence each.
        provenance: Where the data came from.
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
        """Whether the fit converged within its bounds, so that its misfit tells something of the robot."""
        return self.fit.converged and not np.any(self.fit.at_bound)

    @cached_property
    def limits(self) -> ScatterLimits:
        """Misfits that chance explains."""
        return scatter_limits(self.problem, self.fit, self.covariance)

    @property
    def much_missed(self) -> bool:
        """Whether the model misses the responses by many times their uncertainty, so that noise limits nothing."""
        if self.covariance.basis == "residuals":
            return False
        cost, lines = self.covariance.reduced_cost, self.residuals.chi_square
        return cost >= max(self.limits.cost, MUCH**2) or lines >= max(self.limits.chi_square, MUCH**2)

    @cached_property
    def bias_signs(self) -> tuple[str, ...]:
        """Signs that the model lacks something, so that parameters shift by more than their intervals tell."""
        return bias_signs(self.problem, self.covariance, self.residuals, self.limits, self.settled)

    @cached_property
    def nominal_cost(self) -> float:
        """Cost of the robot's values before the identification, at their own rests."""
        return cost_at(self.problem, self.problem.model_at(self.nominal), self.nominal)

    @property
    def same_minimum(self) -> int:
        """Number of starts that ended in the best minimum."""
        costs = self.start_costs
        return int(np.sum(costs <= SAME_MINIMUM * np.min(costs, initial=np.inf)))

    @property
    def start_costs(self) -> FloatArray:
        """Costs of the fits from all starts but those that failed, lowest first, shape (S,)."""
        costs = np.array([each.cost for each in self.searched])
        return np.sort(costs[np.isfinite(costs)])

    def as_dict(self) -> dict[str, Any]:
        """Return all figures for JSON; values in SI units, standard deviations relative to the value.

        Ends of intervals are None where they say nothing.
        """
        return {
            "schema": 1,
            "robot": self.problem.robot.name,
            "estimator": self.fit.estimator,
            "weights": self.fit.weights,
            "verdict": verdict(self),
            "cost": {"nominal": self.nominal_cost, "identified": self.fit.cost},
            "covariance": {
                "basis": self.covariance.basis,
                "reduced_cost": self.covariance.reduced_cost,
                "factor": self.covariance.factor,
                "explanation": covariance_text(self),
                "misfit": self.residuals.chi_square,
                "by_chance": {"reduced_cost": self.limits.cost, "misfit": self.limits.chi_square},
            },
            "bias_signs": list(self.bias_signs),
            "advice": advice(self),
            "parameters": [self._parameter(place) for place in range(len(self.fit.names))],
            "not_determined": [
                {"combination": dict(each.exponents), "std": each.standard_deviation, "text": each.sentence}
                for each in self.identifiability.directions
            ],
            "kept_nominal": list(self.kept_nominal),
            "starts": {
                "number": len(self.searched),
                "failed": len(self.searched) - len(self.start_costs),
                "same_minimum": self.same_minimum,
                "costs": self.start_costs.tolist(),
            },
            "positions": [response.gears.tolist() for response in self.problem.responses],
            "experiment": None if self.facts is None else vars(self.facts),
            "warnings": list(self.warnings),
            "provenance": dict(self.provenance),
        }

    def _parameter(self, place: int) -> dict[str, Any]:
        entry = self.identifiability.parameters[place]
        content: dict[str, Any] = {
            "name": entry.name,
            "unit": entry.unit,
            "nominal": float(self.nominal[place]),
            "value": entry.value,
            "relative_std": float(self.covariance.relative[place]),
            "interval_95": list(known_ends(entry.interval[0], entry.value, entry.interval[1])),
            "verdict": entry.verdict,
            "reason": entry.reason,
            "used": entry.name not in self.kept_nominal,
        }
        if entry.name in self.truth:
            content["truth"] = self.truth[entry.name]
        return content


def identification_result(
    problem: GrayBoxProblem,
    found: GrayBoxFit,
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
        problem: What was fitted last.
        found: The fit that counts.
        searched: Fits from all starts before it.
        design: How the positions were chosen.
        facts: What the experiment took.
        truth: True values (SI) by name, where they are known.
        warnings: What else limits the result.
        provenance: Where the data came from.

    Returns:
        The result.
    """
    covariance = parameter_covariance(problem, found)
    return IdentificationResult(
        problem=problem,
        fit=found,
        searched=tuple(searched),
        covariance=covariance,
        identifiability=identifiability(problem, found, covariance),
        residuals=residual_report(problem, found),
        design=design,
        facts=facts,
        truth={} if truth is None else truth,
        warnings=(*warnings, *own_warnings(problem, found)),
        provenance={} if provenance is None else provenance,
    )
