"""The identification of one axis as a record for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from flexros.provenance import versions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.axis.extremes import Extremes
    from flexros.identify.axis.identification import OneAxisIdentification
    from flexros.identify.axis.prediction_fit import AxisFit, Quality

SCHEMA = 1
"""Version of the record."""

CORRELATED = 0.3
"""Correlation of neighbouring prediction errors from which a model is said to leave something (chosen)."""

WIDEST = 3.0
"""Factor between the ends of a 95 % interval from which a value is said to be hardly told (chosen)."""


def result_record(
    found: OneAxisIdentification,
    joint: str,
    extremes: Extremes,
    logs: Mapping[str, Mapping[str, Any]],
    warnings: tuple[str, ...] = (),
) -> dict[str, Any]:
    """Put an identification into a record of numbers and texts.

    Args:
        found: The identification.
        joint: Name of the motor.
        extremes: Frequencies it started from.
        logs: Provenance of the log, and of the validation log where there is one, by name.
        warnings: What limits the result beyond what the fits tell, one sentence each.

    Returns:
        The record, to be written as JSON; what is not known is None.
    """
    return {
        "schema": SCHEMA,
        "joint": joint,
        "structure": found.nonlinear.structure.model_dump(mode="json"),
        "antiresonances_hz": list(extremes.antiresonances),
        "resonances_hz": list(extremes.resonances),
        "frequencies_from": extremes.source,
        "start": dict(found.start),
        "nonlinear": _model(found.nonlinear, found.validation),
        "linear": _model(found.linear, found.linear_validation),
        "gain": _finite(found.gain),
        "gain_on": "fit" if found.validation is None else "validation",
        "warnings": [*warnings, *_doubts(found)],
        "provenance": {"versions": versions(), "logs": {name: dict(entry) for name, entry in logs.items()}},
    }


def _model(fit: AxisFit, validation: Quality | None) -> dict[str, Any]:
    units = fit.structure.units
    rows = []
    for name, value in fit.parameters.items():
        low, high = fit.interval(name)
        known = math.isfinite(fit.deviation[name])
        rows.append(
            {
                "name": name,
                "value": value,
                "std": fit.deviation[name] if known else None,
                "interval": [low, high] if known else None,
                "unit": units[name],
            }
        )
    return {
        "parameters": rows,
        "fit": _quality(fit.quality),
        "validation": None if validation is None else _quality(validation),
        "error_correlation": _finite(fit.whiteness),
        "converged": fit.converged,
    }


def _quality(quality: Quality) -> dict[str, float | None]:
    return {
        "prediction_error_rms": _finite(quality.error),
        "prediction_percent": _finite(quality.prediction),
        "simulation_percent": _finite(quality.simulation),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _doubts(found: OneAxisIdentification) -> list[str]:
    """Say what of the model that was asked for is not to be relied on."""
    fit = found.nonlinear
    doubts = [] if fit.converged else ["the search did not end by itself; its values are those of the last step"]
    if abs(fit.whiteness) > CORRELATED:
        doubts.append(
            f"neighbouring prediction errors are correlated by {fit.whiteness:.2f}, so the model leaves something of "
            "the log unexplained; another gear law, Stribeck friction or more masses may explain it"
        )
    for name, deviation in fit.deviation.items():
        low, high = fit.interval(name)
        if name != "offset" and not (math.isfinite(deviation) and high <= WIDEST * low):
            doubts.append(f"the log hardly tells {name}: its 95 % interval is wider than a factor of {WIDEST:g}")
    return doubts
