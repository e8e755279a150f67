"""The answer for a robot file whose servo gains are off by far: sizes relative to the file, not to the gains found."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import PlacedEffect
from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.servos import ServoStiffnessError
from flexros.gap.answer.order import in_order
from flexros.gap.schema import Cause, CauseParameter, ModelNumber

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects import RobotWithEffects
    from flexros.gap.result import DiagnosisResult, RankedCandidate
    from flexros.gap.schema import Diagnosis

Factors = dict[tuple[str, str], float]
"""Gains that the diagnosis began with over those of the file [1], by effect and location."""

UNCERTAIN = 0.3
"""Relative standard deviation of a gain that no effect corrects any more [1] (chosen): those of different motions of a
hobby arm differ by as much."""


def relative_to_file(
    result: DiagnosisResult, rough: Sequence[PlacedEffect], given: RobotWithEffects
) -> DiagnosisResult:
    """Restate a result that began with the gains of the log.

    Args:
        result: The result; its effects are relative to the gains that the log shows.
        rough: Errors of the gains of the file.
        given: The nominal model as it was given.
    """
    factors: Factors = {}
    for one in rough:
        assert isinstance(one.effect, AbstractRelativeError)
        factors[one.effect.name, one.location] = 1.0 + one.effect.relative
    diagnosis = _restated(result.diagnosis, factors, given)
    scales = [factors.get(_effect_of(name), 1.0) for name in result.covariance_of]
    covariance = None if result.covariance is None else result.covariance * np.outer(scales, scales)
    patched = bool(result.patch) or diagnosis.verdict != result.diagnosis.verdict
    return replace(
        result,
        diagnosis=diagnosis,
        ranking=tuple(_ranked(one, factors) for one in result.ranking),
        patch=_combined(result.patch, rough, factors) if patched else (),
        covariance=covariance,
    )


def _effect_of(parameter: str) -> tuple[str, str]:
    """Return effect and location of the name of a fitted parameter, e.g. "servo_stiffness_error@motor_1.relative"."""
    effect, _, rest = parameter.partition("@")
    return effect, rest.rpartition(".")[0]


def _on_file(parameters: Mapping[str, CauseParameter], factor: float) -> dict[str, CauseParameter]:
    """Return the size of an error of a gain relative to that of the file."""
    restated = {}
    for name, one in parameters.items():
        value, std = factor * (1.0 + one.value) - 1.0, factor * one.std
        restated[name] = one.model_copy(update={"value": value, "std": std, "determined": std <= abs(value)})
    return restated


def _cause_on_file(cause: Cause, factor: float) -> Cause:
    """Return a cause whose size is relative to the gain of the file."""
    own = _on_file(cause.parameters, factor)
    return cause.model_copy(update={"parameters": own, "determined": any(one.determined for one in own.values())})


def _ranked(one: RankedCandidate, factors: Factors) -> RankedCandidate:
    factor = factors.get((one.effect, one.location))
    return one if factor is None else replace(one, parameters=_on_file(one.parameters, factor))


def _combined(
    patch: Sequence[PlacedEffect], rough: Sequence[PlacedEffect], factors: Factors
) -> tuple[PlacedEffect, ...]:
    """Return the effects of a repair with one error of each gain, relative to the file."""
    combined = []
    for one in patch:
        factor = factors.get((one.effect.name, one.location))
        if factor is not None:
            assert isinstance(one.effect, AbstractRelativeError)
            relative = factor * (1.0 + one.effect.relative) - 1.0
            one = PlacedEffect(type(one.effect)(relative=relative), one.location)
        combined.append(one)
    held = {(one.effect.name, one.location) for one in combined}
    return (*combined, *(one for one in rough if (one.effect.name, one.location) not in held))


def _restated(diagnosis: Diagnosis, factors: Factors, given: RobotWithEffects) -> Diagnosis:
    """Restate what is written into diagnosis.json."""
    verdict = "explained" if diagnosis.verdict == "no_gap" else diagnosis.verdict
    causes = [
        one if factor is None else _cause_on_file(one, factor)
        for one in diagnosis.causes
        for factor in [factors.get((one.effect, one.location))]
    ]
    if verdict != "unknown_effect":  # such errors are certain
        held = {(one.effect, one.location) for one in causes}
        causes += [
            Cause(
                effect=effect,
                location=location,
                probability=1.0,
                parameters={"relative": CauseParameter(value=factor - 1.0, std=UNCERTAIN * factor, unit="1")},
                closed_fraction=None,
            )
            for (effect, location), factor in factors.items()
            if effect == ServoStiffnessError.name and (effect, location) not in held
        ]
    return diagnosis.model_copy(
        update={
            "verdict": verdict,
            "causes": in_order(causes, diagnosis.budget, diagnosis.waterfall),
            "model_numbers": (*_numbers(diagnosis, factors, given),),
            "warnings": (*diagnosis.warnings, _warning(factors, given)),
            "provenance": {**diagnosis.provenance, "robot_hash": given.robot.model_hash},
        }
    )


def _gains(factors: Factors, given: RobotWithEffects) -> dict[str, tuple[float, float]]:
    """Return the gains of the file, and those that the diagnosis began with, by the names of the robot parameters."""
    gains: dict[str, tuple[float, float]] = {}
    for (effect, location), factor in factors.items():
        name = f"{location}.{effect.removesuffix('_error')}"
        nominal = given.robot.parameters[name].value
        gains[name] = nominal, factor * nominal
    return gains


def _numbers(diagnosis: Diagnosis, factors: Factors, given: RobotWithEffects) -> list[ModelNumber]:
    """List the wrong numbers of the file, its gains among them."""
    gains = _gains(factors, given)
    numbers = [
        _number_on_file(one, gains[one.name][0]) if one.name in gains else one for one in diagnosis.model_numbers
    ]
    listed = {one.name for one in numbers}
    return numbers + [
        ModelNumber(
            location=name.partition(".")[0],
            name=name,
            nominal=nominal,
            value=value,
            std=UNCERTAIN * value,
            unit=given.robot.parameters[name].unit,
        )
        for name, (nominal, value) in gains.items()
        if name not in listed and nominal > 0
    ]


def _number_on_file(number: ModelNumber, nominal: float) -> ModelNumber:
    """Return a wrong gain beside that of the file."""
    return number.model_copy(update={"nominal": nominal, "determined": number.std <= abs(number.value - nominal)})


def _warning(factors: Factors, given: RobotWithEffects) -> str:
    gains = _gains({key: one for key, one in factors.items() if key[0] == ServoStiffnessError.name}, given)
    named = ", ".join(
        f"{name} {nominal:.4g} -> {value:.3g} {given.robot.parameters[name].unit}"
        for name, (nominal, value) in gains.items()
    )
    return (
        f"the servo gains of the robot file are off by far, as the weight of the arm is carried with others ({named}): "
        "the diagnosis begins with these, so the gap before the repair is that of a model with them; the patch holds "
        "them. Correct them in the robot file"
    )
