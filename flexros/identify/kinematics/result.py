"""Record of a kinematic identification: accuracy before and after, unknowns with intervals, warnings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.kinematics.fit import KinematicFit
    from flexros.identify.kinematics.record import PoseRecord

NORMAL_95 = 1.959964
"""Half width of a 95 % interval in standard deviations."""

LEARNED = 0.5
"""Largest deviation after over before the measurement of an unknown that the poses determine (chosen)."""


def kinematic_record(fit: KinematicFit, validation: PoseRecord | None = None) -> dict[str, Any]:
    """Return the result ready for JSON.

    Args:
        fit: The fit.
        validation: Poses that were not fitted.
    """
    unknown = fit.unknown
    values = np.concatenate([unknown.values(fit.theta), fit.theta[len(unknown.parameters) :]])
    nominal = np.concatenate([unknown.nominal, np.zeros(6)])
    rows = []
    for k, name in enumerate(unknown.names):
        logarithmic = k < len(unknown.parameters) and bool(unknown.logarithmic[k])
        half = NORMAL_95 * fit.deviations[k]
        ends = values[k] * np.exp([-half, half]) if logarithmic else values[k] + np.array([-half, half])
        unit = (
            unknown.robot.parameters[name].unit if name in unknown.robot.parameters else ("m", "rad")[name[-2] == "r"]
        )
        rows.append(
            {
                "name": name,
                "nominal": float(nominal[k]),
                "value": float(values[k]),
                "interval": [float(end) for end in ends],
                "unit": unit,
                "determined": bool(fit.deviations[k] < LEARNED * unknown.deviation[k]),
            }
        )
    record = {
        "robot": unknown.robot.name,
        "poses": len(fit.residuals),
        "noise": fit.noise,
        "fit": {"before": accuracy(_sizes(fit.before)), "after": accuracy(_sizes(fit.residuals))},
        "validation": None,
        "parameters": rows,
    }
    if validation is not None:
        record["validation"] = {
            "poses": len(validation),
            "before": accuracy(fit.errors(validation, nominal=True)),
            "after": accuracy(fit.errors(validation)),
        }
    return record


def accuracy(errors: FloatArray) -> dict[str, float]:
    """Return mean, mean plus three deviations (positioning accuracy of ISO 9283) and largest distance [mm]."""
    return {
        "mean_mm": float(1e3 * errors.mean()),
        "three_sigma_mm": float(1e3 * (errors.mean() + 3 * errors.std())),
        "max_mm": float(1e3 * errors.max()),
    }


def _sizes(residuals: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(residuals, axis=1))
