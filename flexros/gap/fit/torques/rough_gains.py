"""Gains of servos that are off by far, such as those that only make a simulator stiff.

A servo carries the weight of the arm by its distance from the command, and overcomes dry friction by it. So the torques
that the bodies need, which the robot file gives, are linear in distance, speed and acceleration of each motor and in
the sign of its speed; the factor of the distance is the stiffness of the servo.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import PlacedEffect
from flexros.effects.kinds.servo_number import gains_are_known
from flexros.effects.servos import ServoDampingError, ServoStiffnessError
from flexros.errors import InputError
from flexros.gap.fit.torques.regression import only_coulomb
from flexros.gap.fit.torques.solution import KINDS
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.residuals.torque_rows import ActingTorque, torque_rows
from flexros.identify.rigid.record import torque_as_it_acts
from flexros.record.missing_samples import bridged_motion
from flexros.record.most_informative import most_informative
from flexros.record.torques.servo_torque import servo_torque
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.settings import DiagnosisSettings, ServoStartSettings
    from flexros.identify.rigid.regression_rows import RegressionRows
    from flexros.record.record import Record

BETTER = 0.5
"""Mean squared prediction error with other gains over that with those of the file, below which they count [1] (chosen):
0.06 on a hobby arm whose gains are off by 100, 1.2 and more where an offset of the positions only looks so."""


def rough_gains(record: Record, model: RobotWithEffects, settings: ServoStartSettings) -> tuple[PlacedEffect, ...]:
    """Return errors of the gains of all servos where they are beyond what the search for effects reaches well.

    Servos that carry no weight get the typical factor of those that do, as they mostly are of one make. Damping is
    scaled alike.

    Args:
        record: The log.
        model: The nominal model.
        settings: Settings of the starts of servos.

    Returns:
        An error of stiffness, and of damping where there is any, of every servo whose gains are not known; none where
        the gains of the file are near those of the log, where no servo carries weight, behind springs, and in a
        simulated log.
    """
    robot = model.robot
    if record.command is None or record.simulated or robot.flexible_motors or not only_coulomb(model):
        return ()
    nominal = np.array([robot.parameters[f"{name}.{SERVO}stiffness"].value for name in robot.joint_names])
    factors = carrying_stiffness(record, model, settings) / np.maximum(nominal, 1e-300)
    known = np.isfinite(factors) & (nominal > 0)
    typical = float(np.exp(np.median(np.log(factors[known])))) if known.any() else 1.0
    if abs(np.log(typical)) < np.log(settings.rough_gain):
        return ()
    most = ServoStiffnessError.ranges["relative"].high  # what is beyond is left to the search
    relative = np.minimum(np.where(known, factors, typical) - 1.0, most)
    errors = dict(zip(robot.joint_names, relative.tolist(), strict=True))
    errors = {name: error for name, error in errors.items() if not gains_are_known(robot, name)}
    damped = [name for name in errors if robot.parameters[f"{name}.{SERVO}damping"].value > 0]
    return (
        *(PlacedEffect(ServoStiffnessError(relative=error), name) for name, error in errors.items()),
        *(PlacedEffect(ServoDampingError(relative=errors[name]), name) for name in damped),
    )


def with_gains(record: Record, model: RobotWithEffects) -> Record:
    """Return a log of position commands with the torques of the servos of a model, which scale its tolerance.

    Args:
        record: The log.
        model: The model.
    """
    if record.command is None:
        return record
    position = bridged_motion(record.position, record.valid)
    torque = servo_torque(model.robot, record.command, position, record.sample_time)
    return replace(record, torque=torque)


def likely_gains(record: Record, model: RobotWithEffects, settings: DiagnosisSettings) -> tuple[PlacedEffect, ...]:
    """Return the errors of `rough_gains` where the model predicts the log far better with them; else none.

    An offset between command and position looks like a weak servo as well, but with such gains its motion would lag.

    Args:
        record: The log.
        model: The nominal model.
        settings: Settings of the diagnosis.
    """
    rough = rough_gains(record, model, settings.servo_start)
    if not rough:
        return ()
    other = model.with_effects(rough)
    part = most_informative(record, settings.most_values)
    try:
        level = fit_data(part, model, settings).nominal_level
    except InputError:  # it runs away from the log
        return rough
    try:
        better = fit_data(with_gains(part, other), other, settings).nominal_level < BETTER * level
    except InputError:
        return ()
    return rough if better else ()


def with_likely_gains(
    record: Record, model: RobotWithEffects, repaired: RobotWithEffects | None, settings: DiagnosisSettings
) -> Record:
    """Return a log of position commands with torques of likely gains, where those of a model are off by far.

    They are those that carry the weight, or else those of a repair. Torques of servos that the robot does not have
    would let the log tolerate errors of the torques as large as these.

    Args:
        record: The log.
        model: The nominal model.
        repaired: The model with a repair; None without one.
        settings: Settings of the diagnosis.
    """
    if record.command is None:
        return record
    if rough := likely_gains(record, model, settings):
        return with_gains(record, model.with_effects(rough))
    if repaired is not None and not record.simulated:
        gains = [
            np.array([one.robot.parameters[f"{name}.{SERVO}stiffness"].value for name in model.robot.joint_names])
            for one in (model, repaired)
        ]
        if abs(np.median(np.log(gains[1] / gains[0]))) > np.log(settings.servo_start.rough_gain):
            return with_gains(record, repaired)
    return record


def carrying_stiffness(record: Record, model: RobotWithEffects, settings: ServoStartSettings) -> FloatArray:
    """Return the stiffness with which servos carry the weight of the arm [Nm/rad or N/m], shape (M,).

    It is the median over the delays of the commands that are tried; not a number for a servo that carries too little.

    Args:
        record: The log.
        model: The nominal model.
        settings: Settings of the starts of servos.
    """
    assert record.command is not None
    position = bridged_motion(record.position, record.valid)
    found: list[FloatArray] = []
    for delay in settings.delays:
        late = delay * record.sample_time + model.robot.delay
        command, begin = torque_as_it_acts(replace(record, torque=record.command), late)
        distance = command - position
        rows = torque_rows(record, model.robot, ActingTorque(distance, begin, np.zeros_like(distance)))
        if rows is None:
            return np.full(model.robot.n_motors, np.nan)
        found.append(_stiffness(rows, model, settings.least_carried))
    return np.median(np.array(found), axis=0)  # not a number where one of them is none


def _stiffness(rows: RegressionRows, model: RobotWithEffects, least: float) -> FloatArray:
    """Solve for the stiffness of every servo beside its friction and its rotor."""
    robot, motion = model.robot, rows.motion
    names = [parameter.name for parameter in rows.regressor.parameters]
    own = [[names.index(f"{motor}.{kind}") for kind in KINDS[:-1]] for motor in robot.joint_names]
    bodies = np.array([parameter.nominal for parameter in rows.regressor.parameters])
    bodies[np.ravel(own)] = 0.0
    still = replace(motion, velocity=0 * motion.velocity, acceleration=0 * motion.acceleration)
    at_rest = replace(rows, motion=still, kept=[])
    weight = np.concatenate([H @ bodies for H, _ in at_rest.blocks()])
    blocks = list(rows.blocks())
    stiffness: FloatArray = np.full(robot.n_motors, np.nan)
    for motor in range(robot.n_motors):
        torque = np.concatenate([H[:, motor] @ bodies for H, _ in blocks])
        columns = np.vstack([np.column_stack([one[:, motor], H[:, motor][:, own[motor]]]) for H, one in blocks])
        size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        solution = np.linalg.lstsq(columns / size, torque, rcond=None)[0]
        left, needed = torque - columns / size @ solution, torque @ torque
        carries = weight[:, motor] @ weight[:, motor] > least * needed
        if carries and solution[0] > 0 and left @ left < (1 - least) * needed:
            stiffness[motor] = solution[0] / size[0]
    return stiffness
