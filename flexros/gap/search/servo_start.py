"""Where the search begins for servos under position commands: gains, limits, friction, inertia and delay at once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from flexros.effects.delay import Delay
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.servo_number import gains_are_known
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad, body_numbers, last_moved
from flexros.effects.motor_inertia_error import MotorInertiaError
from flexros.effects.servos import ServoCommandLag, ServoDampingError, ServoStiffnessError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.candidates.candidate import Candidate, free_parameter, list_candidates
from flexros.gap.candidates.competitors import competitors
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.fit.candidate_fit import first_parameters
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.torques.unknown_numbers import inertias_of_bodies
from flexros.gap.search.servo_braking import braking_of, freed, named
from flexros.record.missing_samples import bridged_motion
from flexros.record.torques.servo_torque import servo_torque
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.arrays import BoolArray
    from flexros.effects import AbstractEffect
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.settings import DiagnosisSettings, ServoStartSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

OF_SERVO = (CoulombFriction, ViscousFriction, ServoStiffnessError, MotorInertiaError, RotorInertia)
"""Effects of a servo that stays within its limit. Its damping acts on its speed as viscous friction does."""

_Start: TypeAlias = "tuple[Sequence[tuple[Candidate, float]], Mapping[str, float]]"


def limited_servos(robot: Robot, record: Record, often: float) -> BoolArray:
    """Return which servos reach their torque limits in a log, by their nominal gains, shape (M,).

    Args:
        robot: The nominal robot.
        record: The log.
        often: Share of the samples at its limit from which a servo counts [1].
    """
    if record.command is None:
        return np.zeros(robot.n_motors, dtype=bool)
    position = bridged_motion(record.position, record.valid)
    torque = servo_torque(robot, record.command, position, record.sample_time)
    return np.asarray(np.mean(np.abs(torque[record.valid]) >= robot.torque_limits, axis=0) > often)


def fit_of_servos(
    null: NullFit,
    regressed: CandidateFit | None,
    settings: DiagnosisSettings,
    stop: Callable[[], bool] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> CandidateFit | None:
    """Fit all numbers of servos from several starts.

    The torques of servos are computed from positions, so that a regression of them is one with errors on both sides: it
    makes gains too small, and damping with them. Gains mostly are near those of the model, so the fits also begin
    there. At its limit a servo does not act in proportion to its gains: there the limit is fitted too. Limit and torque
    constant scale the torque alike; both are named `torque_gain_error`. The back-EMF of a hobby servo brakes at the
    limit too, where the damping of the loop has no part: it is viscous friction, and the loop may have hardly any
    damping. A filter of the commands makes a motor late as a delay does; each is tried in place of the other, and both
    together: the search adds one effect at a time, and would not come from a delay to filters at all motors.

    From every start few iterations are made, with tolerated numbers at their nominal values; then the best fits of each
    list of effects go on.

    What a load does that the robot file leaves out, wrong rotors and filters may do nearly as well: where it removes a
    good part of what the best fit leaves, all begin again with it.

    Args:
        null: The nominal model, fitted.
        regressed: The nominal model with what a regression of the torques shows; None without one.
        settings: Settings of the diagnosis.
        stop: Asked after each iteration; True ends the fits where they are, and no further start is fitted.
        progress: Called with "servos" and the share of the starts that are done.

    Returns:
        The best one of the fits that begin with the nominal gains and with those of the regression, and with several
        delays or with filters of the commands; of servos at their limits also without damping. None for logs of
        torques, behind springs, and for a simulated log near its model.
    """
    robot, record = null.model.robot, null.data.record
    far_off = null.data.nominal_level > settings.residuals.far_off
    if record.command is None or robot.flexible_motors or not (record.premises.torques_tell or far_off):
        return None
    begin = settings.servo_start
    limited = limited_servos(robot, record, begin.often_limited)
    competing = competitors(robot, settings.search, null.data.record.prescribed)
    begun = [pair for pair in _begun(null, limited, begin) if competing.contain(pair[0])]
    load = [pair for pair in begun if pair[0].effect is ToolLoad]
    bare = [pair for pair in begun if pair[0].effect is not ToolLoad]
    if not any(pair[0].effect is not ServoCommandLag for pair in bare):
        return None
    plan = partial(
        _plan,
        delays=[delay * record.sample_time for delay in begin.delays],
        first={} if regressed is None else first_parameters(regressed),
        robot=robot,
        undamped=begin.undamped if limited.any() else None,
    )
    fits = _Fits(null, settings, stop, progress)
    found = fits.every(plan(bare), fits.screened, 0.0, 0.3 if load else 0.6)
    if load and found and not fits.over:
        found = _with_load(fits, found, plan, bare, load)
    if not found or fits.over:
        return fits.likeliest(found)
    promising = [(one,) for one in _promising(found, begin.promising)]
    best = fits.likeliest(fits.every(promising, fits.longer, 0.6, 1.0))
    if best is None or fits.over:
        return best
    best = fits.longer(best, settings.fit.final_iterations)
    return best if fits.over else _with_less_damping(fits, best)


def _with_less_damping(fits: _Fits, best: CandidateFit) -> CandidateFit:
    """Return a fit with less damping of servos than in the robot file at motors that it leaves no viscous friction.

    Both brake alike. So the damping is no number of the fits from all starts, and is taken away only where friction,
    which is never negative, does not suffice.

    Args:
        fits: Fits of the log.
        best: The fit.
    """
    null, robot = fits.null, fits.null.model.robot
    candidates = list_candidates(robot, scales_of_motors(robot, null.data.record), measured=True, known=null.model.laws)
    competing = competitors(robot, fits.settings.search, null.data.record.prescribed)
    braking = braking_of([one for one in candidates if competing.contain(one)], robot)
    free = freed(best, braking, null)
    if free is best:
        return best
    less = named(fits.longer(free, fits.settings.fit.final_iterations), braking, null)
    return less if less.chi2 < best.chi2 else best


def _with_load(
    fits: _Fits,
    found: list[CandidateFit],
    plan: Callable[[Sequence[tuple[Candidate, float]]], list[_Start]],
    bare: Sequence[tuple[Candidate, float]],
    load: Sequence[tuple[Candidate, float]],
) -> list[CandidateFit]:
    """Return the fits from all starts with a load that the robot file leaves out, or those found, without one.

    It is tried with the best fit, which goes on before: what few iterations leave may hide what a load does. Within
    the floor, which counts what tolerances allow for, wrong gains and inertias stand for a load: there it must remove a
    good part of all that is left.

    Args:
        fits: Fits of the log.
        found: Fits from all starts without a load.
        plan: Lists the starts with some effects.
        bare: These effects.
        load: The load.
    """
    first = fits.likeliest(found)
    if first is None:
        return found
    best = fits.longer(first)
    own = [pair for pair in bare if pair[0].name in best.names]
    loaded = fits.longer(fits.screened([*own, *load], first_parameters(best)))
    settings, left = fits.settings.search, best.chi2 - fits.null.data.n_values
    least = settings.removed_of_all * left if left > 0 else settings.removed * best.chi2  # within the floor
    if best.chi2 - loaded.chi2 > least:
        return [loaded, *fits.every(plan([*bare, *load]), fits.screened, 0.3, 0.6)]
    return [best if one is first else one for one in found]


@dataclass(frozen=True)
class _Fits:
    """Fits of servos to one log.

    Attributes:
        null: The nominal model, fitted.
        settings: Settings of the diagnosis.
        stop: Asked after each iteration; None to go on to the end.
        progress: Called with "servos" and the share of all work; None for nobody.
    """

    null: NullFit
    settings: DiagnosisSettings
    stop: Callable[[], bool] | None
    progress: Callable[[str, float], None] | None

    @property
    def over(self) -> bool:
        """Whether the time is over."""
        return self.stop is not None and self.stop()

    def screened(self, begun: Sequence[tuple[Candidate, float]], own: Mapping[str, float]) -> CandidateFit:
        """Fit effects a little, from values by their names where these are given; tolerated deviations stay at zero."""
        null, begin = self.null, self.settings.servo_start
        predictor = null.predictor(tuple(one for one, _ in begun))
        sizes = [
            free.encode(own.get(one.name, value) if free is one.free[0] else free.starts[0])
            for one, value in begun
            for free in one.free
        ]
        n_tolerated = predictor.tolerance.n_free
        theta = np.clip(np.concatenate([sizes, np.zeros(n_tolerated)]), *predictor.bounds)
        return fit(
            predictor,
            null.data,
            theta,
            begin.first_iterations,
            tolerance_slopes=np.broadcast_to(0.0, (len(null.data.used), n_tolerated)),
            settings=self.settings.fit,
            stop=self.stop,
        )

    def longer(self, one: CandidateFit, iterations: int | None = None) -> CandidateFit:
        """Let a fit go on, for the iterations of the settings unless others are given."""
        most = self.settings.servo_start.iterations if iterations is None else iterations
        return fit(one.predictor, self.null.data, one.theta, most, settings=self.settings.fit, stop=self.stop)

    def every(
        self, starts: Sequence[tuple[Any, ...]], fitted: Callable[..., CandidateFit], begins: float, ends: float
    ) -> list[CandidateFit]:
        """Fit from several starts, and tell the share of all work before each, between two shares.

        With many servos a single iteration takes long, so that once the time is over, no fit is begun but the first.
        """
        fits: list[CandidateFit] = []
        for done, start in enumerate(starts):
            if fits and self.over:
                break
            if self.progress is not None:
                self.progress("servos", begins + (ends - begins) * done / len(starts))
            fits.append(fitted(*start))
        return fits

    def likeliest(self, fits: Sequence[CandidateFit]) -> CandidateFit | None:
        """Return the fit with the best Bayesian information criterion X / m + p log n (Schwarz 1978), if any.

        The sum of squares X counts over the mean square m that the best fit leaves, if that is more than noise leaves.
        """
        n = self.null.data.n_values
        finite = [one for one in fits if np.isfinite(one.chi2)]
        left = max(min((one.chi2 for one in finite), default=0.0) / n, 1.0)
        return min(finite, key=lambda one: one.chi2 / left + len(one.theta) * np.log(n), default=None)


def _promising(fits: Sequence[CandidateFit], most: int) -> list[CandidateFit]:
    """Return the best fits of each list of effects, the best of all first.

    Args:
        fits: The fits.
        most: Most fits of the same effects.
    """
    ranked = sorted((one for one in fits if np.isfinite(one.chi2)), key=lambda one: one.chi2)
    kept: list[CandidateFit] = []
    for one in ranked:
        if sum(other.names == one.names for other in kept) < most:
            kept.append(one)
    return kept


def _plan(
    begun: Sequence[tuple[Candidate, float]],
    *,
    delays: Sequence[float],
    first: Mapping[str, float],
    robot: Robot,
    undamped: float | None,
) -> list[_Start]:
    """List the starts: each with its effects, and with initial values other than theirs, by name.

    Args:
        begun: The effects with their initial values, filters of the commands among them.
        delays: Initial delays [s].
        first: Values of a regression; empty without one.
        robot: The robot.
        undamped: Relative error of the damping of a loop that hardly brakes, a further value where servos are at their
            limits [1]; None where none is.
    """
    errors = (0.0,) if undamped is None else (0.0, undamped)
    damping = [{f"{ServoDampingError.name}@{name}": error for name in robot.joint_names} for error in errors]
    lags = [pair for pair in begun if pair[0].effect is ServoCommandLag]
    delayed = [pair for pair in begun if pair[0].effect is not ServoCommandLag]
    late = [{f"{Delay.name}@all": delay} for delay in delays]
    plan: list[_Start] = [(delayed, {**one, **other}) for one, other in product(damping, late)]
    if first:
        plan.append((delayed, first))
    if lags:
        punctual = [pair for pair in delayed if pair[0].effect is not Delay]
        plan += product([[*rest, *lags] for rest in (punctual, delayed)], damping)
    return plan


def _begun(null: NullFit, limited: BoolArray, settings: ServoStartSettings) -> list[tuple[Candidate, float]]:
    """List the effects of all servos and of their commands, each with its first parameter and its initial value."""
    robot, record = null.model.robot, null.data.record
    scales = scales_of_motors(robot, record)
    begun = [
        (_wide(effect, location, scales, settings.wider), value)
        for motor in np.flatnonzero(limited).tolist()
        for effect, location, value in _at_limit(robot, record, motor, settings)
    ]
    others = [name for name, one in zip(robot.joint_names, limited, strict=True) if not one]
    bodies = inertias_of_bodies(record, robot)
    for candidate in list_candidates(robot, scales, measured=True, known=null.model.laws):
        first = replace(candidate, free=candidate.free[:1])
        if candidate.effect is ToolLoad:
            begun.append((candidate, settings.little_load * body_numbers(robot, last_moved(robot))[0]))
        elif candidate.effect is ServoCommandLag:
            begun.append((first, settings.lag * record.sample_time))
        elif (candidate.effect in OF_SERVO and candidate.location in others) or candidate.name == f"{Delay.name}@all":
            little = settings.little_friction * first.free[0].high
            begun.append((first, little if candidate.effect is CoulombFriction else 0.0))
            if candidate.effect is RotorInertia:
                begun[-1] = (first, settings.little_rotor * bodies[candidate.location])
    return begun


def _at_limit(
    robot: Robot, record: Record, motor: int, settings: ServoStartSettings
) -> list[tuple[type[AbstractEffect], str, float]]:
    """List the effects of a servo at its limit, where they are, and the values that the fits begin with."""
    name, limit = robot.joint_names[motor], robot.torque_limits[motor]
    speed = np.gradient(bridged_motion(record.position, record.valid)[:, motor], record.sample_time)[record.valid]
    fastest = float(np.quantile(np.abs(speed), 0.95))
    values: list[tuple[type[AbstractEffect], float]] = [
        (CoulombFriction, settings.friction * limit),
        (ViscousFriction, settings.braking * limit / max(fastest, 1e-9)),
        (TorqueGainError, 0.0),
    ]
    known = gains_are_known(robot, name)
    if not known:
        values.append((ServoStiffnessError, 0.0))
    if robot.parameters[f"{name}.inertia"].value > 0:
        values.append((MotorInertiaError, 0.0))
    if not known and robot.parameters[f"{name}.{SERVO}damping"].value > 0:
        values.append((ServoDampingError, 0.0))
    return [(effect, name, value) for effect, value in values]


def _wide(effect: type[AbstractEffect], location: str, scales: Scales, wider: float) -> Candidate:
    """Return an effect of a servo at its limit with its first parameter free, in a wide range."""
    # nobody knows the limit of a servo better than its gains, and friction is measured by its torque
    ranges = ServoStiffnessError.ranges if effect is TorqueGainError else effect.ranges
    name, allowed = next(iter(ranges.items()))
    if allowed.scale.startswith("torque"):
        allowed = replace(allowed, high=wider * allowed.high)
    return Candidate(effect, location, (free_parameter(name, allowed, scales.of(allowed.scale, location)),))
