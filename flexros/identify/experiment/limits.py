"""Limits of position, speed and torque, checked on the nominal model before an experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.config.per_motor import per_motor
from flexros.errors import InputError
from flexros.identify.experiment.excursion import faded, half_way
from flexros.identify.experiment.loop_prediction import LoopPrediction
from flexros.identify.experiment.margin import Margin, Swing, smallest_margin
from flexros.identify.experiment.slow_motion import ConstantSpeed, NoSlowMotion
from flexros.trajectory.path import text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.feedforward.motion import Reference
    from flexros.identify.excitation.base import BlockSignals
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.experiment.timetable import Visit
    from flexros.robot import Robot

ROTARY = {"position": "rad", "speed": "rad/s", "torque": "Nm"}
LINEAR = {"position": "m", "speed": "m/s", "torque": "N"}


def check_limits(plan: ExperimentPlan, robot: Robot, law: AbstractControlLaw, reference: Reference) -> None:
    """Refuse an experiment in which the nominal robot would leave a limit.

    Position and speed are those of the reference. The torque is predicted: what holds the robot at rest and drives it
    at the slow motion, and what the excitation causes in the linear closed loop. So is the motor speed that must not
    turn a constant speed back. Moves are checked by their feedforward torque.

    Args:
        plan: The plan.
        robot: The nominal robot.
        law: The feedback controller.
        reference: The reference of the whole experiment, with its feedforward torque.

    Raises:
        InputError: A limit is left; names position, motor, quantity, by how much, and the largest amplitude.
    """
    allowed = plan.specification.limits.torque_share * law.command_limits(robot)
    for visit in plan.visits:
        _check_move(plan, robot, visit, reference, allowed)
    prediction = LoopPrediction.of(plan, robot, law)
    worst: tuple[Margin, Visit] | None = None
    near = robot.home
    for visit in plan.visits:
        rest = robot.equilibrium(near, motor_position=reference.motor_position[visit.lead])
        near = rest[: robot.n_arm]
        at_rest = prediction.at(rest)
        for block in range(visit.n_experiments // plan.n_motors):
            signals = plan.signals(visit.position, block)
            torque, speed = at_rest.torque(signals), at_rest.speed(signals)
            for experiment in range(plan.n_motors):
                swings = [*_motion(plan, visit, signals, experiment, speed[experiment])]
                swings.append(Swing("torque", *at_rest.offset, torque[experiment], -allowed, allowed))
                margin = smallest_margin(swings)
                if worst is None or margin.factor < worst[0].factor:
                    worst = margin, visit
    if worst is not None and worst[0].factor < 1.0:
        raise _refusal(plan, robot, *worst)


def _motion(
    plan: ExperimentPlan, visit: Visit, signals: BlockSignals, experiment: int, predicted: FloatArray
) -> Iterator[Swing]:
    """Give position and speed of an experiment as far as they are limited, and the predicted speed not to turn back."""
    limits, slow, m = plan.specification.limits, plan.specification.slow_motion, plan.n_motors
    whole = faded(plan, signals, experiment)
    slow_speed = np.zeros(m) if isinstance(slow, NoSlowMotion) else slow.speeds(m)
    if isinstance(slow, ConstantSpeed) and not slow.allow_reversal:
        yield Swing("speed against the slow motion", np.zeros(m), np.zeros(m), predicted, -slow_speed, slow_speed)
    if limits.speed is not None:
        fastest = per_motor("identification.limits.speed", limits.speed, m)
        yield Swing("speed", -slow_speed, slow_speed, whole.speed, -fastest, fastest)
    if limits.position is not None:
        low, high = np.array(limits.position).T
        gears, way = plan.positions[visit.position], half_way(plan)
        yield Swing("position", gears - way, gears + way, whole.position, low, high)


def _check_move(plan: ExperimentPlan, robot: Robot, visit: Visit, reference: Reference, allowed: FloatArray) -> None:
    """Refuse a move whose feedforward torque is too large."""
    if visit.lead == visit.begin:
        return
    fastest = plan.specification.limits.speed
    if fastest is not None:
        speed = np.max(np.abs(reference.motor_velocity[visit.begin : visit.lead]), axis=0)
        over = speed / per_motor("identification.limits.speed", fastest, plan.n_motors)
        motor = int(np.argmax(over))
        if over[motor] > 1.0:
            raise InputError(
                f"{_place(plan, visit)}: {robot.joint_names[motor]} moves there at up to {speed[motor]:.4g} "
                f"{_unit(robot, motor, 'speed')}, allowed are {speed[motor] / over[motor]:.4g}; lower "
                "identification.move.speed"
            )
    torque = np.abs(reference.torque[visit.begin : visit.lead])
    largest = np.max(torque, axis=0)
    motor = int(np.argmax(largest / allowed))
    if largest[motor] > allowed[motor]:
        where = visit.begin + int(np.argmax(torque[:, motor]))
        what = "hold the robot" if where >= visit.arrive else "move there"
        raise InputError(
            f"{_place(plan, visit)}: {robot.joint_names[motor]} needs {largest[motor]:.4g} "
            f"{_unit(robot, motor, 'torque')} to {what}, allowed are {allowed[motor]:.4g}; lower "
            "identification.move.acceleration or choose another position"
        )


def _refusal(plan: ExperimentPlan, robot: Robot, margin: Margin, visit: Visit) -> InputError:
    """Word the error of a limit that is exceeded, with the remedy."""
    motor, name = margin.motor, margin.name
    unit = _unit(robot, motor, name.split()[0])
    said = (
        f"{_place(plan, visit)}: {robot.joint_names[motor]} would reach a {name} of {margin.reached:.4g} {unit} on the "
        f"nominal model, {margin.offset:.4g} {unit} of it without excitation, allowed are {margin.allowed:.4g} {unit}"
    )
    if margin.factor <= 0.0:
        return InputError(f"{said}; choose another position or a slower slow_motion")
    amplitude = np.floor(np.atleast_1d(plan.specification.excitation.amplitude) * margin.factor * 1e4) / 1e4
    largest = f"{amplitude[0]:.4g}" if amplitude.size == 1 else text(amplitude)
    return InputError(
        f"{said}; lower identification.excitation.amplitude to {margin.factor:.3g} times what is given, at most "
        f"{largest}"
    )


def _place(plan: ExperimentPlan, visit: Visit) -> str:
    return f"identification.positions[{visit.position}] {text(plan.positions[visit.position])}"


def _unit(robot: Robot, motor: int, quantity: str) -> str:
    rotary = robot.motors[motor].rotary
    return (ROTARY if rotary else LINEAR)[quantity]
