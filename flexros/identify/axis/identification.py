"""Three-step identification of a nonlinear model of one axis (Wernholt and Gunnarsson 2006, thesis 4.2.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import unknown_name
from flexros.identify.axis.gear_law import PARAMETERS
from flexros.identify.axis.prediction_fit import AxisFit, Quality, fit_axis
from flexros.identify.axis.predictor import Predictor
from flexros.identify.axis.record import AxisRecord, axis_record
from flexros.identify.axis.search_setup import bounds_around, short_steps, starting_values
from flexros.identify.axis.structure import AxisStructure
from flexros.identify.log_record import log_record
from flexros.prediction.damped_least_squares import StopRule

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.record.topic_reader import TorqueSource
    from flexros.robot import Robot

SMOOTHING = 0.01
"""Speed over which friction changes sign, relative to the rms speed (chosen)."""

STIFFENINGS = (1.5, 0.7)
"""Initial stiffening factors of the gear (chosen)."""

KNEES = (0.6, 0.3, 0.85)
"""Shares of the samples whose deflection is below the knee, for initial knees (chosen)."""


MOVES = 0.1
"""Speed of another motor, relative to that of the axis (rms), above which it is reported (chosen)."""

LOADS = 0.01
"""Holding torque at home, relative to the torque of the axis (rms), above which gravity is reported (chosen)."""


@dataclass(frozen=True, eq=False)
class OneAxisIdentification:
    """A nonlinear model of one axis and the linear-spring model of the same record.

    Attributes:
        nonlinear: The model with the chosen gear law.
        linear: The same with a linear gear.
        start: Values of the linear steps, by name.
        validation: Quality of the nonlinear model on the validation log; None without one.
        linear_validation: Quality of the linear-spring model there.
        warnings: Repairs and doubts about the logs, and effects that the model does not contain, one sentence each.
    """

    nonlinear: AxisFit
    linear: AxisFit
    start: Mapping[str, float]
    validation: Quality | None
    linear_validation: Quality | None
    warnings: tuple[str, ...] = ()

    @property
    def gain(self) -> float:
        """Share of the prediction error removed by the nonlinear gear [1], on the validation log if there is one."""
        if self.validation is None or self.linear_validation is None:
            return 1 - self.nonlinear.quality.error / self.linear.quality.error
        return 1 - self.validation.error / self.linear_validation.error


def identify_one_axis(
    log: Log,
    robot: Robot,
    structure: AxisStructure | None = None,
    *,
    joint: str = "motor_1",
    antiresonances: Sequence[float] = (),
    resonances: Sequence[float] = (),
    start: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    validation: Log | None = None,
    smoothing: float | None = None,
    torque: TorqueSource = "command",
) -> OneAxisIdentification:
    """Identify an axis from commands and motion of its motor, in three steps.

    First the rigid axis with friction by regression; then masses and springs from the resonances of the frequency
    response; then all parameters, with the nonlinear gear, by minimal one-step prediction errors. The last step is
    repeated with a linear gear, for comparison.

    Args:
        log: Log of the axis, moving from rest.
        robot: The nominal robot: its joints, and the delay of the command.
        structure: Model structure; default: two masses, piecewise linear gear, output position.
        joint: Name of the motor.
        antiresonances: Minima of the response from torque to motor motion [Hz], one less than masses; optional if
            `start` has inertias and stiffnesses.
        resonances: Its peaks [Hz], as many.
        start: Initial values by name; they replace those of the linear steps.
        bounds: Lower and upper bounds by name; default: a factor of 10 above and below the initial value, of 1000 for
            friction and the knee of the gear.
        validation: Another log of the axis, for validation.
        smoothing: Speed over which friction changes sign [rad/s or m/s]; default: 1 % of the rms speed.
        torque: Torque that is taken where both were recorded.

    Returns:
        Both models with standard deviations and qualities.

    Raises:
        InputError: The log is not usable, or a name, initial value or frequency is invalid.
    """
    structure = AxisStructure() if structure is None else structure
    given = dict(bounds or {})
    for name in given:
        if name not in structure.names:
            raise unknown_name("parameter of the axis", name, structure.names, "bounds")
    if joint not in robot.joint_names:
        raise unknown_name("joint", joint, robot.joint_names, f"robot {robot.name}")
    motor = robot.joint_names.index(joint)
    whole = log_record(log, robot, name="the log", torque=torque)
    record = axis_record(whole, motor, structure.output, robot.delay)
    other = None
    if validation is not None:
        held_out = log_record(validation, robot, name="the validation log", torque=torque)
        other = axis_record(held_out, motor, structure.output, robot.delay)
    smoothing = SMOOTHING * record.rms_speed if smoothing is None else smoothing
    begin = starting_values(record, structure, smoothing, antiresonances, resonances, start or {})
    plain = structure.model_copy(update={"gear": "linear"})
    predictor = Predictor(plain, record, smoothing, short_steps(begin, record, smoothing))
    linear = fit_axis(predictor, record, begin, bounds_around(plain, begin, given, record))
    nonlinear = linear if structure.gear == "linear" else _nonlinear(structure, linear, record, begin, given)
    return OneAxisIdentification(
        nonlinear=nonlinear,
        linear=linear,
        start=begin,
        validation=None if other is None else nonlinear.judge(other),
        linear_validation=None if other is None else linear.judge(other),
        warnings=(*record.warnings, *(() if other is None else other.warnings), *unmodelled(whole, robot, motor)),
    )


def _nonlinear(
    structure: AxisStructure,
    linear: AxisFit,
    record: AxisRecord,
    begin: Mapping[str, float],
    given: Mapping[str, tuple[float, float]],
) -> AxisFit:
    """Fit the nonlinear gear from several initial values around the linear one; complete the best short search."""
    predictor = Predictor(structure, record, linear.predictor.smoothing, linear.predictor.substeps)
    states = linear.predictor.states(record, linear.values, linear.gain)
    deflection = np.abs(states[:, linear.structure.speed_index - linear.structure.masses + 1])
    known = {name: begin[name] for name in PARAMETERS[structure.gear] if name in begin}
    gears = [known] if len(known) == len(PARAMETERS[structure.gear]) else _gear_starts(structure, deflection)
    bounds = bounds_around(structure, {**begin, **gears[0], **known}, given, record)
    short = StopRule(step=1e-3, decrease=1e-4, iterations=8, evaluations=16)
    trials = [
        fit_axis(predictor, record, {**begin, **linear.parameters, **gear, **known}, bounds, rounds=1, stop=short)
        for gear in gears
    ]
    best = min(trials, key=lambda trial: trial.quality.error)
    return fit_axis(predictor, record, best.parameters, bounds)


def _gear_starts(structure: AxisStructure, deflection: FloatArray) -> list[dict[str, float]]:
    """Spread initial values of the gear nonlinearity over the deflections of the linear model, the most usual first."""
    if structure.gear == "cubic":
        typical = float(np.sqrt(np.mean(deflection**2)))
        return [{"gear_doubling": factor * typical} for factor in (4.0, 1.5, 12.0)]
    knees = np.quantile(deflection, KNEES).tolist()
    return [{"gear_stiffening": factor, "gear_knee": knee} for knee in knees for factor in STIFFENINGS]


def unmodelled(record: Record, robot: Robot, motor: int) -> tuple[str, ...]:
    """Find gravity on the axis, and motion of other motors.

    Args:
        record: Record of the log.
        robot: The nominal robot.
        motor: Number of the motor (0-based).

    Returns:
        One sentence for each; empty where neither is significant.
    """
    return (*_gravity(record, robot, motor), *_other_motion(record, robot, motor))


def _gravity(record: Record, robot: Robot, motor: int) -> tuple[str, ...]:
    holding = robot.holding_torque(robot.equilibrium(robot.home))[motor]
    rms = np.sqrt(np.mean(record.torque[:, motor] ** 2))
    if abs(holding) <= LOADS * rms:
        return ()
    return (
        f"gravity loads {robot.joint_names[motor]} by {abs(holding):.3g} at home, but the model of the axis has no "
        "gravity; take an axis that gravity does not load, or a constant torque (offset) where it moves little",
    )


def _other_motion(record: Record, robot: Robot, motor: int) -> tuple[str, ...]:
    speed = np.sqrt(np.mean(np.diff(record.position, axis=0) ** 2, axis=0))
    moving = [
        name for other, name in enumerate(robot.joint_names) if other != motor and speed[other] > MOVES * speed[motor]
    ]
    if not moving:
        return ()
    joint = robot.joint_names[motor]
    return (f"the model of the axis has no other motion, but {', '.join(moving)} moves too; move {joint} alone",)
