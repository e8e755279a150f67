"""Where fits of servos begin: their effects with initial values, and the lists of them that are tried."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from flexros.effects.counterbalance import Counterbalance
from flexros.effects.delay import Delay
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.servo_number import gains_are_known
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad, body_numbers, last_moved
from flexros.effects.motor_inertia_error import MotorInertiaError
from flexros.effects.servos import ServoCommandLag, ServoDampingError, ServoStiffnessError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.candidates.candidate import Candidate, free_parameter, from_zero, list_candidates
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.fit.torques.unknown_numbers import inertias_of_bodies
from flexros.record.missing_samples import bridged_motion
from flexros.record.torques.servo_torque import servo_torque
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import BoolArray
    from flexros.effects import AbstractEffect
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.settings import ServoStartSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

OF_SERVO = (CoulombFriction, ViscousFriction, ServoStiffnessError, MotorInertiaError, RotorInertia)
"""Effects of a servo that stays within its limit. Its damping acts on its speed as viscous friction does."""

LARGEST_ROTOR = 100.0
"""Inertia of a rotor, seen through its gear, over that of the bodies it moves, up to which fits begin [1] (chosen)."""

SLOWEST_SERVO = 2.0
"""Natural frequency of a servo with its rotor alone, down to which fits begin too [Hz] (chosen): the rotor of the last
wrist of an arm has a thousand times the inertia of its flange."""

CARRIED = (ToolLoad, Counterbalance)
"""Effects that change the weight which servos carry: few logs have one, and wrong gains stand for them."""

Begun: TypeAlias = "Sequence[tuple[Candidate, float]]"
"""Effects, each with the value that its first parameter begins with [its unit]."""

Start: TypeAlias = "tuple[Begun, Mapping[str, float]]"
"""Effects, and values of first parameters that they begin with instead, by effect@location [their units]."""


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


def starts(
    begun: Begun,
    *,
    delays: Sequence[float],
    first: Mapping[str, float],
    robot: Robot,
    undamped: float | None,
) -> list[Start]:
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
    plan: list[Start] = [(delayed, {**one, **other}) for one, other in product(damping, late)]
    if first:
        plan.append((delayed, first))
    if lags:
        punctual = [pair for pair in delayed if pair[0].effect is not Delay]
        plan += product([[*rest, *lags] for rest in (punctual, delayed)], damping)
    return plan


def begun_of(null: NullFit, limited: BoolArray, settings: ServoStartSettings) -> list[tuple[Candidate, float]]:
    """List the effects of all servos and of their commands, each with its first parameter and its initial value."""
    robot, record = null.model.robot, null.data.record
    scales = scales_of_motors(robot, record)
    bodies = inertias_of_bodies(record, robot)
    begun = [
        (_wide(effect, robot.joint_names[motor], scales, settings.wider), value)
        for motor in np.flatnonzero(limited).tolist()
        for effect, value in _at_limit(robot, record, motor, bodies, settings)
    ]
    others = [name for name, one in zip(robot.joint_names, limited, strict=True) if not one]
    for candidate in list_candidates(robot, scales, measured=True, known=null.model.laws):
        first = replace(candidate, free=candidate.free[:1])
        if candidate.effect is ToolLoad:
            begun.append((candidate, settings.little_load * body_numbers(robot, last_moved(robot))[0]))
        elif candidate.effect is Counterbalance:
            begun.append((candidate, 0.0))
        elif candidate.effect is ServoCommandLag:
            begun.append((first, settings.lag * record.sample_time))
        elif (candidate.effect in OF_SERVO and candidate.location in others) or candidate.name == f"{Delay.name}@all":
            little = settings.little_friction * first.free[0].high
            begun.append((first, little if candidate.effect is CoulombFriction else 0.0))
            if candidate.effect is RotorInertia:
                begun[-1] = (first, settings.little_rotor * bodies[candidate.location])
    return begun


def moved_from_zero(begun: Begun, record: Record, robot: Robot) -> list[tuple[Candidate, float]]:
    """Let fits move friction, rotors and delays themselves, not their logarithms.

    Args:
        begun: The effects with their initial values.
        record: The log.
        robot: The nominal robot.
    """
    most = {f"{RotorInertia.name}@{motor}": one for motor, one in _largest_rotors(record, robot).items()}
    return [
        (replace(one, free=tuple(from_zero(free, most.get(one.name)) for free in one.free)), value)
        for one, value in begun
    ]


def _largest_rotors(record: Record, robot: Robot) -> dict[str, float]:
    """Return the largest inertias of rotors that fits begin with, by motor [kg m2 or kg]."""
    stiffness = {motor: robot.parameters[f"{motor}.{SERVO}stiffness"].value for motor in robot.joint_names}
    return {
        motor: max(LARGEST_ROTOR * inertia, stiffness[motor] / (2 * np.pi * SLOWEST_SERVO) ** 2)
        for motor, inertia in inertias_of_bodies(record, robot).items()
    }


def _at_limit(
    robot: Robot, record: Record, motor: int, bodies: Mapping[str, float], settings: ServoStartSettings
) -> list[tuple[type[AbstractEffect], float]]:
    """List the effects of a servo at its limit, and the values that the fits begin with."""
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
    else:
        values.append((RotorInertia, settings.little_rotor * bodies[name]))
    if not known and robot.parameters[f"{name}.{SERVO}damping"].value > 0:
        values.append((ServoDampingError, 0.0))
    return values


def _wide(effect: type[AbstractEffect], location: str, scales: Scales, wider: float) -> Candidate:
    """Return an effect of a servo at its limit with its first parameter free, in a wide range."""
    # nobody knows the limit of a servo better than its gains, and friction is measured by its torque
    ranges = ServoStiffnessError.ranges if effect is TorqueGainError else effect.ranges
    name, allowed = next(iter(ranges.items()))
    if allowed.scale.startswith("torque"):
        allowed = replace(allowed, high=wider * allowed.high)
    return Candidate(effect, location, (free_parameter(name, allowed, scales.of(allowed.scale, location)),))
