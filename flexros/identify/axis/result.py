"""JSON record of the identification of one axis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from flexros.provenance import versions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.axis.identification import OneAxisIdentification
    from flexros.identify.axis.prediction_fit import AxisFit, Quality
    from flexros.identify.axis.resonances import Resonances

SCHEMA = 1
"""Version of the record."""

CORRELATED = 0.3
"""Correlation of neighbouring prediction errors above which a model-form error is reported (chosen)."""

WIDEST = 3.0
"""Factor between the ends of a 95 % interval above which a value is reported as uncertain (chosen)."""


def result_record(
    identification: OneAxisIdentification,
    joint: str,
    frequencies: Resonances,
    logs: Mapping[str, Mapping[str, Any]],
) -> dict[str, Any]:
    """Return an identification as a record, ready for JSON; unknown values are None.

    Args:
        identification: The identification.
        joint: Name of the motor.
        frequencies: Frequencies from which the initial values were computed.
        logs: Provenance of the log, and of the validation log if there is one, by name.
    """
    return {
        "schema": SCHEMA,
        "joint": joint,
        "structure": identification.nonlinear.structure.model_dump(mode="json"),
        "antiresonances_hz": list(frequencies.antiresonances),
        "resonances_hz": list(frequencies.resonances),
        "frequencies_from": frequencies.source,
        "start": dict(identification.start),
        "nonlinear": _model(identification.nonlinear, identification.validation),
        "linear": _model(identification.linear, identification.linear_validation),
        "gain": _finite(identification.gain),
        "gain_on": "fit" if identification.validation is None else "validation",
        "warnings": [*identification.warnings, *_doubts(identification)],
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


def _doubts(identification: OneAxisIdentification) -> list[str]:
    """Report which parts of the nonlinear model are unreliable."""
    fit = identification.nonlinear
    doubts = [] if fit.converged else ["the search did not converge; the values are from its last step"]
    if abs(fit.whiteness) > CORRELATED:
        doubts.append(
            f"neighbouring prediction errors are correlated by {fit.whiteness:.2f}, so the model leaves part of the "
            "log unexplained; another gear law, Stribeck friction or more masses may explain it"
        )
    for name, deviation in fit.deviation.items():
        low, high = fit.interval(name)
        if name != "offset" and not (math.isfinite(deviation) and high <= WIDEST * low):
            doubts.append(f"the log hardly determines {name}: its 95 % interval is wider than a factor of {WIDEST:g}")
    return doubts
