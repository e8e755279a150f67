"""The figures of an identification for identification.json."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.identify.report.verdict import advice, covariance_text, verdict
from flexros.identify.report.words import known_ends

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult


def identification_record(result: IdentificationResult) -> dict[str, Any]:
    """Return all figures for JSON; values in SI units, standard deviations relative to the value.

    Ends of intervals are None where they are unknown.
    """
    return {
        "schema": 1,
        "robot": result.problem.robot.name,
        "estimator": result.fit.estimator,
        "weights": result.fit.weights,
        "verdict": verdict(result),
        "cost": {"nominal": result.nominal_cost, "identified": result.fit.cost},
        "covariance": {
            "basis": result.covariance.basis,
            "reduced_cost": result.covariance.reduced_cost,
            "factor": result.covariance.factor,
            "explanation": covariance_text(result),
            "misfit": result.residuals.chi_square,
            "by_chance": {"reduced_cost": result.limits.cost, "misfit": result.limits.chi_square},
        },
        "bias_signs": list(result.bias_signs),
        "advice": advice(result),
        "parameters": [_parameter(result, index) for index in range(len(result.fit.names))],
        "not_determined": [
            {"combination": dict(each.exponents), "std": each.standard_deviation, "text": each.sentence}
            for each in result.identifiability.directions
        ],
        "kept_nominal": list(result.kept_nominal),
        "starts": {
            "number": len(result.searched),
            "failed": len(result.searched) - len(result.start_costs),
            "same_minimum": result.same_minimum,
            "costs": result.start_costs.tolist(),
        },
        "positions": [response.gears.tolist() for response in result.problem.responses],
        "experiment": None if result.facts is None else vars(result.facts),
        "warnings": list(result.warnings),
        "provenance": dict(result.provenance),
    }


def _parameter(result: IdentificationResult, index: int) -> dict[str, Any]:
    entry = result.identifiability.parameters[index]
    content: dict[str, Any] = {
        "name": entry.name,
        "unit": entry.unit,
        "nominal": float(result.nominal[index]),
        "value": entry.value,
        "relative_std": float(result.covariance.relative[index]),
        "interval_95": list(known_ends(entry.interval[0], entry.value, entry.interval[1])),
        "verdict": entry.verdict,
        "reason": entry.reason,
        "used": entry.name not in result.kept_nominal,
    }
    if entry.name in result.truth:
        content["truth"] = result.truth[entry.name]
    return content
