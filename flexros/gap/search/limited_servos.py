"""Where the search begins for servos that reach their torque limits: gains, limit, friction and delay at once."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.coulomb_friction import CoulombFriction
from flexros.effects.delay import Delay
from flexros.effects.motor_inertia_error import MotorInertiaError
from flexros.effects.servos import ServoDampingError, ServoStiffnessError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.effects.viscous_friction import ViscousFriction
from flexros.gap.candidates.candidate import Candidate, free_parameter
from flexros.gap.candidates.competitors import competitors
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.fit.least_squares import CandidateFit, fit
from flexros.record.missing_samples import bridged_motion
from flexros.record.servo_torque import servo_torque
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import BoolArray
    from flexros.effects import AbstractEffect
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

OFTEN_LIMITED = 0.01
"""Share of the samples at its torque limit from which a servo counts as one that reaches it [1] (chosen)."""
FRICTION = 0.1
"""Coulomb friction that the fits begin with, over the torque limit [1] (chosen)."""
BRAKE = 0.5
"""Viscous friction that the fits begin with at the largest speed, over the torque limit [1] (chosen): a voltage that is
limited ends the acceleration where the back-EMF reaches it."""
UNDAMPED = -0.85
"""Relative error of the damping of a loop that hardly brakes, with which one of the fits begins [1] (chosen)."""
WIDER = 10.0
"""Factor by which friction may exceed what the largest nominal torque overcomes [1], as the gains of a servo may be
wrong by it (chosen)."""
DELAYS = (0.25, 1.25, 2.25, 3.25)
"""Delays that the fits begin with [samples] (chosen): between whole ones, at which the prediction has a corner."""
SCREENED = 8
"""Iterations after which the best one of the fits goes on alone (chosen)."""


def limited_servos(robot: Robot, record: Record) -> BoolArray:
    """Return which servos reach their torque limits in a log, by their nominal gains, shape (M,)."""
    if record.command is None:
        return np.zeros(robot.n_motors, dtype=bool)
    position = bridged_motion(record.position, record.valid)
    torque = servo_torque(robot, record.command, position, record.sample_time)
    return np.asarray(np.mean(np.abs(torque[record.valid]) >= robot.torque_limits, axis=0) > OFTEN_LIMITED)


def fit_of_limited_servos(
    null: NullFit, settings: DiagnosisSettings, stop: Callable[[], bool] | None = None
) -> CandidateFit | None:
    """Fit all numbers of servos that reach their torque limits.

    At its limit a servo does not act in proportion to its gains, so that no regression of torques shows them. The limit
    and the torque constant scale the torque alike: both are named `torque_gain_error`. The back-EMF of a hobby servo
    brakes at the limit too, where the damping of the loop has no part: it is viscous friction, and the loop may have
    hardly any damping.

    Args:
        null: The nominal model, fitted.
        settings: Settings of the diagnosis.
        stop: Asked after each iteration; True ends the fits where they are.

    Returns:
        The best one of the fits that begin with and without damping of the loop, and with several delays; None where
        no servo reaches its limit, for a simulated log near its model, and where none of the effects competes.
    """
    robot, record = null.model.robot, null.data.record
    far_off = null.data.nominal_level > settings.residuals.far_off
    if robot.flexible_motors or not (record.imported or far_off):
        return None
    limited = limited_servos(robot, record)
    if not limited.any():
        return None
    begun = [pair for motor in np.flatnonzero(limited).tolist() for pair in _of_motor(robot, record, motor)]
    begun.append((Delay, "all", 0.0))
    scales, competing = scales_of_motors(robot, record), competitors(robot, settings.search)
    pairs = [(_candidate(effect, location, scales), value) for effect, location, value in begun]
    pairs = [(one, value) for one, value in pairs if competing.contain(one)]
    if not pairs:
        return None
    predictor = null.predictor(tuple(one for one, _ in pairs))
    tried = []
    for error, delay in product((0.0, UNDAMPED), DELAYS):
        own: dict[type[AbstractEffect], float] = {ServoDampingError: error, Delay: delay * record.sample_time}
        sizes = [one.free[0].encode(own.get(one.effect, value)) for one, value in pairs]
        theta = np.clip(np.concatenate([sizes, np.zeros(predictor.tolerance.n_free)]), *predictor.bounds)
        tried.append(fit(predictor, null.data, theta, SCREENED, settings=settings.fit, stop=stop))
    best = min((one for one in tried if np.isfinite(one.chi2)), key=lambda one: one.chi2, default=None)
    if best is None:
        return None
    return fit(predictor, null.data, best.theta, settings.fit.final_iterations, settings=settings.fit, stop=stop)


def _of_motor(robot: Robot, record: Record, motor: int) -> list[tuple[type[AbstractEffect], str, float]]:
    """List the effects of one servo, where they are, and the values that the fits begin with."""
    name, limit = robot.joint_names[motor], robot.torque_limits[motor]
    speed = np.gradient(bridged_motion(record.position, record.valid)[:, motor], record.sample_time)[record.valid]
    fastest = float(np.quantile(np.abs(speed), 0.95))
    values: list[tuple[type[AbstractEffect], float]] = [
        (CoulombFriction, FRICTION * limit),
        (ViscousFriction, BRAKE * limit / max(fastest, 1e-9)),
        (ServoStiffnessError, 0.0),
        (TorqueGainError, 0.0),
    ]
    if robot.parameters[f"{name}.inertia"].value > 0:
        values.append((MotorInertiaError, 0.0))
    if robot.parameters[f"{name}.{SERVO}damping"].value > 0:
        values.append((ServoDampingError, 0.0))
    return [(effect, name, value) for effect, value in values]


def _candidate(effect: type[AbstractEffect], location: str, scales: Scales) -> Candidate:
    """Return an effect with its first parameter free."""
    # nobody knows the limit of a servo better than its gains, and friction is measured by its torque
    ranges = ServoStiffnessError.ranges if effect is TorqueGainError else effect.ranges
    name, allowed = next(iter(ranges.items()))
    if allowed.scale.startswith("torque"):
        allowed = replace(allowed, high=WIDER * allowed.high)
    return Candidate(effect, location, (free_parameter(name, allowed, scales.of(allowed.scale, location)),))
