"""The gap as a budget: shares of effects and classes, and wrong numbers of the model."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import effects
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad, body_numbers, last_moved, seen_axes
from flexros.gap.answer.decision import effect_location
from flexros.gap.answer.partial_repairs import PartialRepairs
from flexros.gap.answer.rivals.scale_doubt import parameters_of_answer
from flexros.gap.answer.strained_numbers import strained_numbers
from flexros.gap.answer.unexplained import unexplained
from flexros.gap.answer.waterfall import waterfalls
from flexros.gap.fit.limits import numbers_at_limits
from flexros.gap.fit.uncertainty.between_logs import with_variation_between_logs
from flexros.gap.fit.uncertainty.covariance import fit_covariance
from flexros.gap.held_out.closed_share import closed_fraction, share_between
from flexros.gap.schema import BudgetShare, ModelNumber

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects import AbstractEffect
    from flexros.gap.answer.decision import Findings
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.schema import EffectLocation, Unexplained, Waterfall
    from flexros.robot import Robot

    _Row = tuple[str, str, str | None]

CLEAR = 2.0
"""Standard deviations from which the number of a body counts as other than that of the file [1] (chosen)."""
MODEL_NUMBERS = "model numbers"
_CLASSES: Mapping[str, str] = MappingProxyType({"motor friction": "friction"})
"""Classes of a budget by stage of the loop, where they are named otherwise."""


@dataclass(frozen=True)
class Budget:
    """The gap of held-out data, divided.

    Attributes:
        shares: Shares of effects, and of classes with several effects at a joint, the largest first.
        waterfalls: The same by joint, an effect at a time.
        unexplained: What the repaired model leaves, the largest first.
        model_numbers: Numbers of the nominal model that the effects correct.
    """

    shares: tuple[BudgetShare, ...] = ()
    waterfalls: tuple[Waterfall, ...] = ()
    unexplained: tuple[Unexplained, ...] = ()
    model_numbers: tuple[ModelNumber, ...] = ()


def class_of(effect: type[AbstractEffect]) -> str:
    """Return the class of an effect in a budget: its stage, or `MODEL_NUMBERS` for errors of parameters."""
    number = issubclass(effect, AbstractChangedValues) and not issubclass(effect, AbstractLaw)
    return MODEL_NUMBERS if number else _CLASSES.get(effect.stage, effect.stage)


def joint_of(location: str, robot: Robot) -> str:
    """Return the motor at a location: itself, or that of its spring; else the location."""
    for motor in robot.motors:
        if location in (motor.name, motor.joint.name):
            return motor.name
    return location


def budget_of(findings: Findings, before: AheadErrors, after: AheadErrors) -> Budget:
    """Divide the gap of the held-out log among the effects of the chosen explanation.

    Added first, an effect alone is put on the nominal model; removed last, it alone is taken from the repaired one. The
    two differ where effects overlap. All have the sizes at which they explain the log together: alone one may be too
    large, or act against what others do, and then it closes less than nothing.

    Args:
        findings: The fits of one log, checked on another.
        before: Errors of the nominal model.
        after: Errors of the repaired one.
    """
    chosen = findings.explanations.chosen
    gap = before.mean - 1.0
    rest = unexplained(findings, before, after)
    if gap <= 0 or not chosen.hypothesis:
        return Budget(unexplained=rest, model_numbers=_model_numbers(findings))
    repairs = PartialRepairs(findings, before, after)
    rows = _members([effect_location(name) for name in _in_order(repairs)], findings.model.robot)
    own = [_names(members) for _, members in rows]
    repairs.prepare([*(repairs.kept | names for names in own), *(repairs.names - names for names in own)])
    shares = [_share(repairs, *row) for row in rows]
    shares.sort(key=lambda share: -(share.share_last or 0.0))
    return Budget(tuple(shares), waterfalls(repairs), rest, _model_numbers(findings))


def _in_order(repairs: PartialRepairs) -> list[str]:
    """List what the gap is divided among: numbers that the model lacks, then the effects as they were found."""
    effects = (candidate.name for candidate in repairs.findings.explanations.chosen.hypothesis)
    return [*sorted(repairs.findings.as_given.lacking), *(name for name in effects if name in repairs.names)]


def _names(members: Sequence[EffectLocation]) -> frozenset[str]:
    return frozenset(f"{one.effect}@{one.location}" for one in members)


def _share(repairs: PartialRepairs, name: _Row, members: tuple[EffectLocation, ...]) -> BudgetShare:
    """Compute the share of an effect, or of the effects of a class at a joint."""
    joint, cause_class, effect = name
    own, every, kept = _names(members), repairs.names, repairs.kept
    sample_time = repairs.findings.held.record.sample_time
    last = repairs.closed_by(every) - repairs.closed_by(every - own)
    closed = None if own <= kept else closed_fraction(repairs.before, repairs.errors(kept | own), sample_time)
    opened = share_between(repairs.before, repairs.errors(every - own), repairs.errors(every), sample_time)
    return BudgetShare.model_validate(
        {
            "joint": joint,
            "class": cause_class,
            "effect": effect,
            "location": members[0].location if effect else joint,
            "share_first": None if closed is None else closed.value,
            "share_last": last,
            "interval": None if closed is None else closed.interval,
            "interval_last": None if opened is None else opened.interval,
        }
    )


def without_gap(findings: Findings) -> Budget:
    """Return the budget of a log without a gap: numbers alone that the robot file lacks.

    Args:
        findings: The fits of the log.
    """
    return Budget(model_numbers=tuple(_estimated(findings)))


def _members(divided: Sequence[EffectLocation], robot: Robot) -> list[tuple[_Row, tuple[EffectLocation, ...]]]:
    """List the effects, and the classes of which a joint has several: joint, class, effect and members."""
    classes: dict[tuple[str, str], list[EffectLocation]] = {}
    for one in divided:
        key = (joint_of(one.location, robot), class_of(effects()[one.effect]))
        classes.setdefault(key, []).append(one)
    rows: list[tuple[_Row, tuple[EffectLocation, ...]]] = []
    for (joint, cause_class), members in classes.items():
        rows += [((joint, cause_class, one.effect), (one,)) for one in members]
        if len(members) > 1:
            rows.append(((joint, cause_class, None), tuple(members)))
    return rows


def _model_numbers(findings: Findings) -> tuple[ModelNumber, ...]:
    """List the parameters of the robot that effects of the chosen explanation correct."""
    chosen, robot = findings.explanations.chosen, findings.model.robot
    numbers = []
    for candidate, parameters in zip(chosen.hypothesis, parameters_of_answer(findings)):
        if class_of(candidate.effect) != MODEL_NUMBERS or candidate.name in findings.beyond_search:
            continue
        placed = candidate.placed({name: parameter.value for name, parameter in parameters.items()})
        if isinstance(placed.effect, ToolLoad):
            numbers += [
                _load_number(name, one.value, one.std, one.unit, determined=one.determined)
                for name, one in parameters.items()
            ]
            continue
        assert isinstance(placed.effect, AbstractChangedValues)
        parts = []  # the values are linear in each parameter
        for name, parameter in parameters.items():
            alone = candidate.placed({name: parameter.value}).effect
            assert isinstance(alone, AbstractChangedValues)
            parts.append((alone.values(robot, candidate.location), parameter))
        for name, value in placed.effect.values(robot, candidate.location).items():
            nominal = robot.parameters[name].value
            if value == nominal:
                continue
            own = [(values[name] - nominal, parameter) for values, parameter in parts if values[name] != nominal]
            deviations = [change / parameter.value * parameter.std for change, parameter in own]
            numbers.append(
                ModelNumber(
                    location=candidate.location,
                    name=name,
                    nominal=nominal,
                    value=value,
                    std=float(np.linalg.norm(deviations)),
                    unit=robot.parameters[name].unit,
                    determined=all(parameter.determined for _, parameter in own),
                )
            )
    return _together([*_estimated(findings), *numbers])


def _together(numbers: Sequence[ModelNumber]) -> tuple[ModelNumber, ...]:
    """Return each number once: a fit adds what an effect and a tolerated deviation change of it."""
    found: dict[str, ModelNumber] = {}
    for one in numbers:
        other = found.get(one.name)
        found[one.name] = (
            one
            if other is None
            else one.model_copy(
                update={
                    "value": other.value + one.value - one.nominal,
                    "std": float(np.hypot(other.std, one.std)),
                    "determined": other.determined and one.determined,
                    "at_limit": other.at_limit or one.at_limit,
                }
            )
        )
    return tuple(found.values())


def _estimated(findings: Findings) -> list[ModelNumber]:
    """List the numbers that the robot file lacks, or that are far out of tolerance, as the chosen explanation has them.

    A log shows the inertia of a rotor together with that of the bodies that always turn with it, and of masses and
    centres some combinations alone: what the file leaves open of the others is a doubt about each.
    """
    chosen, robot = findings.explanations.chosen, findings.model.robot
    tolerance = chosen.predictor.tolerance
    n = chosen.predictor.n_effect
    whole = fit_covariance(chosen, findings.data, findings.settings)
    covariance = with_variation_between_logs(whole, chosen, findings.held, findings.settings)[n:, n:]
    fitted = tolerance.fitted(covariance)
    relative = dict(zip(tolerance.names, fitted))
    with_uninformed = dict(zip(tolerance.names, np.hypot(fitted, tolerance.uninformed)))
    numbers = []
    for placed in findings.unknown.fitted(chosen):
        name, effect = f"{placed.location}.inertia", placed.effect
        if isinstance(effect, ToolLoad):
            numbers += _of_load(effect, robot, relative, findings.unknown.bare)
            continue
        if isinstance(effect, ViscousFriction):
            continue  # no number of its own: it takes that of the file away
        if isinstance(effect, BodyDifference):
            numbers += _of_body(effect, placed.location, findings.given.robot, with_uninformed)
            continue
        assert isinstance(effect, RotorInertia)
        numbers.append(
            ModelNumber(
                location=placed.location,
                name=name,
                nominal=0.0,
                value=effect.added,
                std=float(with_uninformed[name]) * effect.added,
                unit=robot.parameters[name].unit,
                determined=bool(with_uninformed[name] <= 1.0),
            )
        )
    strained = strained_numbers(findings)
    limited = numbers_at_limits(chosen)
    moved = (_moved(*one, robot, float(relative[one[0]]), at_limit=one[0] in limited) for one in strained.items())
    return [*numbers, *moved]


def _moved(name: str, factor: float, robot: Robot, relative: float, *, at_limit: bool) -> ModelNumber:
    """Return a number that the answer moves far out of its tolerance.

    Args:
        name: Its name.
        factor: Its value over the nominal one [1].
        robot: The nominal robot.
        relative: Relative standard deviation [1].
        at_limit: Whether it is as far out as is searched: no log determines it there.
    """
    parameter = robot.parameters[name]
    value = factor * parameter.value
    return ModelNumber(
        location=name.partition(".")[0],
        name=name,
        nominal=parameter.value,
        value=value,
        std=abs(value) * relative,
        unit=parameter.unit,
        determined=not at_limit and relative * factor <= abs(factor - 1.0),
        at_limit=at_limit,
    )


def _of_body(difference: BodyDifference, body: str, robot: Robot, relative: Mapping[str, float]) -> list[ModelNumber]:
    """List mass and centre of a body where they differ clearly, and by more than their stated tolerance.

    Inertias of single bodies are hardly determined one by one; the patch holds them all the same.
    """
    numbers = []
    for name, value in difference.values(robot, body).items():
        parameter = robot.parameters[name]
        if ".inertia." in name:
            continue
        std = float(relative.get(name, 0.0)) * abs(value)
        if abs(value - parameter.value) > max(parameter.tolerance * abs(parameter.value), CLEAR * std):
            numbers.append(
                ModelNumber(
                    location=body,
                    name=name,
                    nominal=parameter.value,
                    value=value,
                    std=std,
                    unit=parameter.unit,
                    determined=True,
                )
            )
    return numbers


def _of_load(load: ToolLoad, robot: Robot, relative: Mapping[str, float], bare: float) -> list[ModelNumber]:
    """List mass and place of a load, with the deviations of those of the body that carries it.

    The log shows both together: what the body alone is known to is a doubt about the load. A coordinate along an axis
    about which all joints turn is no finding, as no torque depends on it.

    Args:
        load: The load.
        robot: The robot with it.
        relative: Relative deviations of the parameters by name [1].
        bare: Mass of the body alone [kg].
    """
    body = last_moved(robot)
    mass, center, _ = body_numbers(robot, body)
    of_bare = robot.parameters[f"{body}.mass"].tolerance * bare
    place = np.array([load.x, load.y, load.z])
    apart = mass / max(bare, 1e-300) * float(np.linalg.norm(center - place))  # from the body alone
    of_center = [relative.get(f"{body}.center_of_mass.{axis}", 0.0) for axis in "xyz"]
    deviation = float(np.hypot(relative.get(f"{body}.mass", 0.0) * mass, of_bare))
    farther = float(np.hypot(np.max(np.abs(center) * of_center) * mass, of_bare * apart)) / max(load.mass, 1e-300)
    values = (
        ("mass", load.mass, deviation, "kg"),
        *((axis, getattr(load, axis), farther, "m") for axis in seen_axes(robot, body)),
    )
    determined = deviation <= load.mass  # a place is known as well at zero, where there is a load
    return [_load_number(*one, determined=determined) for one in values]


def _load_number(name: str, value: float, std: float, unit: str, *, determined: bool) -> ModelNumber:
    """Return mass or place of a load that the robot file leaves out."""
    return ModelNumber(
        location="tool", name=f"tool_load.{name}", nominal=0.0, value=value, std=std, unit=unit, determined=determined
    )
