"""The fit that the search begins with on a real machine: friction, motor inertia and counterbalance, all at once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.base_tilt import BaseTilt
from flexros.effects.encoders.encoder_offset import EncoderOffset
from flexros.effects.left_out.tool_load import ToolLoad, last_moved
from flexros.effects.torque_curve import TorqueCurve
from flexros.gap.candidates.candidate import Candidate, candidate_at, free_parameter, list_candidates
from flexros.gap.candidates.competitors import competitors
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.fit.torques.arm_torque import arm_torque
from flexros.gap.fit.torques.balanced import regress_balanced
from flexros.gap.fit.torques.delay import torque_delay
from flexros.gap.fit.torques.missing_load import lowered, may_carry
from flexros.gap.fit.torques.regression import only_coulomb, regress_torque
from flexros.gap.fit.torques.rough_bodies import is_inertial, with_rough_bodies
from flexros.gap.fit.torques.solution import is_silent, rest_of
from flexros.gap.fit.torques.turned_weight import with_turned_weight
from flexros.gap.residuals.torque_errors import torque_errors
from flexros.gap.search.model_probability import compare

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.fit.torques.arm_torque import ArmTorque
    from flexros.gap.fit.torques.position_torque import PositionTorque
    from flexros.gap.fit.torques.solution import TorqueRegression
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import DiagnosisSettings, TorqueStartSettings
    from flexros.record.record import Record
    from flexros.robot import Robot


RELIEVED_BY_LOAD = 0.65
"""Penalty of tolerated numbers with a load behind springs over that without it, below which it is there [1]
(chosen)."""
LEFT_BY_LOAD = 0.2
"""What a fit with a load leaves on a rigid arm, over what one without it leaves, below which it is there [1]
(chosen)."""
OF_DEVIATIONS = (1.0, 0.5, 0.25, 0.0)
"""Shares of the regressed deviations of tolerated numbers, tried in turn until the robot can be predicted [1]
(chosen)."""
KNOWN = 0.1
"""Tolerance of the mass of the last body below which it carries no load that was estimated before [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class TorqueStart:
    """Effects that the torques of a log show, with initial values.

    Attributes:
        regression: The regression that shows them.
        model: The nominal model.
        record: The log.
        delay: Delay of commanded positions, or of torques [s].
        loaded: The same with a load that the robot file may lack, not clear in the torques alone; None without one.
    """

    regression: TorqueRegression
    model: RobotWithEffects
    record: Record
    delay: float = 0.0
    loaded: TorqueStart | None = None

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.model.robot

    def hypothesis(self) -> list[tuple[Candidate, tuple[float, ...]]]:
        """List the effects with the initial values of their first parameters [their units]."""
        found = self.regression
        values: dict[tuple[str, str], float] = {}
        for motor, name in enumerate(self.robot.joint_names):
            nominal = self.robot.parameters[f"{name}.inertia"].value
            inertia = float(found.inertia[motor])
            values["viscous_friction", name] = float(found.viscous_friction[motor])
            values["coulomb_friction", name] = float(found.coulomb_friction[motor])
            values["torque_bias", name] = float(found.bias[motor]) if self.record.command is None else 0.0
            values["motor_inertia_error", name] = inertia / nominal if nominal > 0 else 0.0
            values[EncoderOffset.name, name] = found.zeros.get(motor, 0.0)
            values["servo_stiffness_error", name] = float(found.servo_stiffness[motor])
        values["delay", "all"] = self.delay
        scales = scales_of_motors(self.robot, self.record)
        single = [
            (replace(candidate, free=candidate.free[:1]), (value,))
            for candidate in list_candidates(self.robot, scales, measured=True, known=self.model.laws)
            if (value := values.get((candidate.effect.name, candidate.location), 0.0)) != 0
        ]
        several = (*self._load(scales), *self._tilt(scales))
        return [*single, *several, *(self._over_position(one, scales) for one in found.position_torques)]

    def _load(self, scales: Scales) -> list[tuple[Candidate, tuple[float, ...]]]:
        """Return the load with its mass and place, if any."""
        mass, moment = float(self.regression.load[0]), self.regression.load[1:]
        if mass <= 0:
            return []
        sizes = {"mass": mass, **dict(zip("xyz", (moment / mass).tolist(), strict=True))}
        load = candidate_at(ToolLoad, "tool", self.robot, scales)
        return [(load, tuple(sizes[free.name] for free in load.free))]

    def _tilt(self, scales: Scales) -> list[tuple[Candidate, tuple[float, ...]]]:
        """Return the slant of the base, if any."""
        angles = self.regression.tilt
        tilt = candidate_at(BaseTilt, "base", self.robot, scales)
        return [(tilt, tuple(angles[free.name] for free in tilt.free))] if angles else []

    def _over_position(self, torque: PositionTorque, scales: Scales) -> tuple[Candidate, tuple[float, ...]]:
        """Return a counterbalance or a curve of a motor with the initial values of its sizes."""
        location, effect = self.robot.joint_names[torque.motor], torque.effect
        free = tuple(
            free_parameter(name, allowed, scales.of(allowed.scale, location)) for name, allowed in effect.ranges.items()
        )
        fixed = () if torque.span is None else tuple(zip(TorqueCurve.extent, torque.span, strict=True))
        return Candidate(effect, location, free, fixed, together=torque.span is not None), torque.sizes


def torque_start(
    data: FitData, model: RobotWithEffects, tolerance: Tolerance, settings: DiagnosisSettings
) -> TorqueStart | None:
    """Regress the torques of a log of a real machine, or of one whose nominal model is far off.

    Args:
        data: Log and weights.
        model: The nominal model.
        tolerance: Parameters of the robot that may deviate.
        settings: Settings of the diagnosis.

    Returns:
        What the torques show; None where that is nothing, for a simulated log near its model, where positions were
        commanded to servos behind springs, and for a model with known laws other than Coulomb friction, which the
        regression lacks.
    """
    record = data.record
    far_off = data.nominal_level > settings.residuals.far_off
    if not only_coulomb(model) or not (record.premises.torques_tell or far_off):
        return None
    if record.command is not None:
        start = _servo_start(record, model, tolerance, settings.torque_start)
    else:
        arm = arm_torque(data, model, tolerance)
        delay = torque_delay(record, model, tolerance, settings.torque_start)
        regression = _balanced(record, model, tolerance, arm, delay, settings.torque_start)
        if regression is not None:
            clear = np.abs(regression.bias) > data.measurement.tolerated_torque(record)
            regression = replace(regression, bias=np.where(clear, regression.bias, 0.0))
        start = None if regression is None else TorqueStart(regression, model, record, delay)
        if regression is not None and start is not None:
            start = replace(start, loaded=_loaded_start(start, tolerance, settings.torque_start))
    return start if start is not None and start.hypothesis() else None


def _loaded_start(start: TorqueStart, tolerance: Tolerance, settings: TorqueStartSettings) -> TorqueStart | None:
    """Return a start with a load that the robot file may lack; None where there is no sign of one.

    Behind springs torques alone do not show it. Where none hide it, most loads are clear before, see `clear_load`, and
    others leave less of the torques than another mass of the last body does.

    Args:
        start: What the torques show without it.
        tolerance: Parameters of the robot that may deviate.
        settings: Settings of the regression.
    """
    robot, torques = start.robot, start.regression.position_torques
    known = tolerance.largest([f"{last_moved(robot)}.mass"]) < KNOWN
    if not may_carry(robot) or not (robot.flexible_motors or known):
        return None
    regress = partial(
        regress_torque,
        start.record,
        start.model,
        Tolerance(),
        delay=start.delay,
        position_torques=torques,
        settings=settings,
    )
    loaded = regress(load="point")
    if loaded is None or not loaded.load[0] > 0:
        return None
    if not robot.flexible_motors:
        payload = regress(load="body")
        if payload is None or lowered(payload, loaded, settings) < settings.perhaps_load:
            return None
    loaded = replace(loaded, deviations=np.zeros_like(start.regression.deviations))
    return TorqueStart(loaded, start.model, start.record, start.delay)


def _balanced(
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    arm: ArmTorque | None,
    delay: float,
    settings: TorqueStartSettings,
) -> TorqueRegression | None:
    """Regress the torques, beside a counterbalance where there is one, with encoders and base as they ask for.

    Viscous friction that differs by direction passes for an offset: where it leaves less, there is none.
    """
    best = regress_balanced(record, model, tolerance, arm, delay=delay, settings=settings)
    if best is None:
        return None
    regress = partial(
        regress_torque,
        record,
        model,
        tolerance,
        arm,
        delay=delay,
        position_torques=best.position_torques,
        settings=settings,
    )
    rough = with_rough_bodies(tolerance, settings.rough_bodies) == tolerance and any(map(is_inertial, tolerance.names))
    best = with_turned_weight(regress, best, model.robot, record, settings, rough=rough) or best
    if not best.bias.any():
        return best
    uneven = regress(uneven=True, zeros=best.zeros, tilt=best.tilt)
    return best if uneven is None else replace(best, bias=np.where(uneven.rest < best.rest, 0.0, best.bias))


def _servo_start(
    record: Record, model: RobotWithEffects, tolerance: Tolerance, settings: TorqueStartSettings
) -> TorqueStart | None:
    """Regress the torques of servos with the delay of the commands that leaves least of them."""
    if model.robot.flexible_motors:
        return None
    best: tuple[float, TorqueStart] | None = None
    for samples in range(settings.longest_delay + 1):
        delay = samples * record.sample_time
        found = regress_torque(record, model, tolerance, delay=delay, settings=settings)
        if found is None:
            break
        left = rest_of(found)
        if best is not None and left > best[0]:
            break
        best = left, TorqueStart(found, model, record, delay)
    return None if best is None else best[1]


def with_torques(data: FitData, start: TorqueStart | None) -> FitData:
    """Let the errors of the torques of a measured log count beside prediction errors, where no spring hides them.

    Their deviation is what the regression leaves, but no less than a part of the tolerance of the torques.

    Args:
        data: Log and weights.
        start: What its torques show; None for nothing.
    """
    record = data.record
    if start is None or not record.premises.torques_tell or record.command is not None or start.robot.flexible_motors:
        return data
    least = data.settings.torque_start.least_rest * data.measurement.tolerated_torque(record)
    rest = np.where(record.predicted, np.maximum(start.regression.rest, least), 0.0)
    deviation = np.where(is_silent(rest), np.inf, rest)
    return replace(data, torques=torque_errors(record, start.model, start.delay, deviation))


def first_values(start: TorqueStart, null: NullFit, settings: DiagnosisSettings) -> CandidateFit | None:
    """Put the effects of a start on the nominal model, with their values by the torques.

    Args:
        start: The start.
        null: The nominal model, fitted.
        settings: Settings of the diagnosis.

    Returns:
        The effects with these values; None where none of them competes, or no robot with them can be predicted. Torques
        may ask for bodies that no arm has: then these are less off, as far as needed.
    """
    competing = competitors(start.robot, settings.search, start.record.prescribed)
    pairs = [(one, values) for one, values in start.hypothesis() if competing.contain(one)]
    if not pairs:
        return None
    sizes = np.array(
        [free.encode(value) for one, values in pairs for free, value in zip(one.free, values, strict=True)]
    )
    hypothesis, deviations = tuple(candidate for candidate, _ in pairs), start.regression.deviations
    trials = (_at(null, hypothesis, sizes, share * deviations) for share in OF_DEVIATIONS)
    return next((one for one in trials if np.isfinite(one.chi2)), None)


def on_null(null: NullFit, fit: CandidateFit) -> CandidateFit:
    """Put a fit on the nominal model of another fit, which may leave other tolerated deviations free.

    Args:
        null: The nominal model, fitted.
        fit: The fit.
    """
    sizes, deviations = fit.theta[: fit.predictor.n_effect], fit.predictor.tolerance.by_name(fit.deviations)
    return _at(null, fit.hypothesis, sizes, deviations)


def base_fit(
    null: NullFit, first: CandidateFit, settings: DiagnosisSettings, stop: Callable[[], bool] | None = None
) -> CandidateFit | None:
    """Fit the effects of a start to a log; None where they remove little or gain no more than chance.

    Then every candidate must be tried alone: a base that explains little would end the search.

    Args:
        null: The nominal model, fitted.
        first: The effects with their first values.
        settings: Settings of the diagnosis.
        stop: Asked after each iteration; True ends the fit where it is.
    """
    enough = max(settings.fit.enough, null.data.negligible)
    iterations = settings.fit.final_iterations
    base = fit(first.predictor, null.data, first.theta, iterations, enough=enough, settings=settings.fit, stop=stop)
    floor, before = null.data.n_values, null.fit.chi2
    removed, within = settings.search.removed_of_all, settings.search.within_floor
    most = before - removed * (before - floor) if before > floor else within * before
    detected = compare(null.data, null.fit, [base], settings=settings.ranking).detected
    return base if detected and base.chi2 < most else None


def with_load(
    null: NullFit,
    base: CandidateFit,
    loaded: TorqueStart,
    settings: DiagnosisSettings,
    stop: Callable[[], bool] | None = None,
) -> CandidateFit:
    """Return the effects of a start with a load that the robot file lacks, where a fit shows it clearly.

    Behind springs torques alone do not show it clearly: what springs leave is larger than what the load explains. It is
    clear where it removes a good part of what is left, or much of what else tolerated numbers must deviate by. On a
    rigid arm, where friction, offsets and bodies have the torques to themselves, it must leave far less than these.

    Args:
        null: The nominal model, fitted.
        base: The fit of the effects without a load.
        loaded: The start with a load.
        settings: Settings of the diagnosis.
        stop: Asked after each iteration; True ends the fit where it is.
    """
    first = first_values(loaded, null, settings)
    fit_of_load = None if first is None else base_fit(null, first, settings, stop)
    if fit_of_load is None or fit_of_load.chi2 > base.chi2:
        return base
    if not loaded.robot.flexible_motors:
        return fit_of_load if fit_of_load.chi2 < LEFT_BY_LOAD * base.chi2 else base
    left = max(base.chi2 - null.data.n_values, 0.0)
    removes = left > 0 and base.chi2 - fit_of_load.chi2 > settings.search.removed_of_all * left
    relieves = fit_of_load.prior_penalty < RELIEVED_BY_LOAD * base.prior_penalty
    return fit_of_load if removes or relieves else base


def _at(null: NullFit, hypothesis: Hypothesis, sizes: FloatArray, deviations: FloatArray) -> CandidateFit:
    """Evaluate effects of given sizes, encoded, with given deviations of the tolerated parameters."""
    predictor = null.predictor(hypothesis)
    theta = np.clip(np.concatenate([sizes, predictor.tolerance.along(deviations)]), *predictor.bounds)
    return CandidateFit(predictor, theta, float(chi2_of(predictor, null.data, theta[:, None])[0]))
