"""JSON record of a rigid regression."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from flexros.identify.rigid.excitation import LARGEST_CONDITION
from flexros.identify.rigid.fit import LARGEST_ERROR
from flexros.identify.rigid.friction_effects import friction_outside_file
from flexros.provenance import versions

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.identify.rigid.fit import RigidFit, TorqueError
    from flexros.identify.rigid.identified_robot import IdentifiedRobot
    from flexros.identify.rigid.verdict import Verdict

SCHEMA = 1
"""Version of the record."""


def result_record(
    fit: RigidFit,
    verdict: Verdict,
    cross_tests: Sequence[TorqueError],
    logs: Mapping[str, Mapping[str, Any]],
) -> dict[str, Any]:
    """Return a fit and its cross-tests as a record, ready for JSON.

    Args:
        fit: The fit.
        verdict: The verdict on it.
        cross_tests: Torque errors on other logs.
        logs: Provenance of all logs by name.
    """
    identified, outside = verdict.identified, friction_outside_file(fit)
    return {
        "schema": SCHEMA,
        "verdict": {"usable": verdict.usable, "sentence": verdict.sentence, "largest_error_percent": LARGEST_ERROR},
        "robot": fit.robot.name,
        "settings": fit.settings.model_dump(mode="json"),
        "torque": "measured" if fit.measured_torque else "command",
        "cutoff_hz": fit.cutoff,
        "rate_hz": fit.rate,
        "rows": fit.error.rows,
        "parameters": _parameters(fit),
        "excitation": _excitation(fit),
        "force_error_percent": {
            "fit": _error(fit, fit.error),
            "fit_with_hold": fit.error_with_hold,
            "robot_file": verdict.file_error,
            "cross_tests": [_error(fit, t) for t in cross_tests],
        },
        "identified_values": _identified_values(fit, identified),
        "left_at_nominal": dict(identified.left_out),
        "not_met": dict(identified.not_met),
        "not_in_robot_file": {"values": dict(outside.values), "effects": list(outside.effects)},
        "means_in_robot_file": list(outside.means),
        "warnings": list(fit.warnings),
        "provenance": {"versions": versions(), "model_hash": fit.robot.model_hash, "logs": dict(logs)},
    }


def _excitation(fit: RigidFit) -> dict[str, Any]:
    return {
        "rich_enough": fit.rich_enough,
        "condition_number": fit.condition,
        "largest_condition_number": LARGEST_CONDITION,
        "not_excited": [{"name": entry.name, "reason": entry.reason} for entry in fit.excitation.not_excited],
        "motors_that_stood_still": [
            name for name, moved in zip(fit.robot.joint_names, fit.moving, strict=True) if not moved
        ],
        "without_effect_in_any_motion": list(fit.base.without_effect),
    }


def _identified_values(fit: RigidFit, identified: IdentifiedRobot) -> dict[str, Any]:
    return {
        name: {
            "value": entry.value,
            "std": entry.relative * abs(entry.value),
            "unit": fit.robot.parameters[name].unit,
        }
        for name, entry in identified.values.items()
    }


def _parameters(fit: RigidFit) -> list[dict[str, Any]]:
    rows = []
    for index, name in enumerate(fit.base.names):
        shown = index in fit.excitation.shown
        value, deviation = float(fit.values[index]), float(fit.deviation[index])
        rows.append(
            {
                "name": name,
                "words": fit.base.words(index),
                "combination": fit.base.parts(index),
                "value": value,
                "std": deviation if shown else None,
                "relative_std_percent": 100 * deviation / abs(value) if shown and value else None,
                "unit": fit.base.units[index],
                "nominal": float(fit.base.nominal[index]),
                "estimated": shown,
            }
        )
    return rows


def _error(fit: RigidFit, error: TorqueError) -> dict[str, Any]:
    finite = [value if math.isfinite(value) else None for value in error.motors.tolist()]
    motors = dict(zip(fit.robot.joint_names, finite, strict=True))
    return {"log": error.label, "total": error.total, "motors": motors, "rows": error.rows}
