"""Friction and motor inertia of all motors at once, by regression of the torque: where the search for causes begins.

With springs locked and speeds from the measured positions, the torque is linear in friction, in the inertias of the
motors and nearly in the parameters of the bodies (Moberg 2007, eq. 4.11 to 4.13). With springs, the torque that the arm
takes from the motors is added, which is nearly linear in the tolerated parameters. Unlike prediction errors it stays so
however far the nominal model is off, so one solution finds what every robot has: friction at all joints, and rotors
that the model lacks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.base_tilt import BaseTilt
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.kinds.servo_number import gains_are_known
from flexros.effects.left_out.tool_load import ENTRIES, last_moved
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.torques.solution import KINDS, LOAD, ROUNDS, Sought, is_silent, solve
from flexros.gap.residuals.torque_rows import acting_torque, torque_rows
from flexros.gap.settings import TorqueStartSettings
from flexros.identify.rigid.standard_parameters import standard_parameters
from flexros.record.missing_samples import bridged_motion
from flexros.record.one_way import ONE_WAY
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.torques.arm_torque import ArmTorque
    from flexros.gap.fit.torques.position_torque import PositionTorque
    from flexros.gap.fit.torques.solution import Load, TorqueRegression
    from flexros.gap.residuals.torque_rows import ActingTorque
    from flexros.identify.rigid.regression_rows import RegressionRows
    from flexros.record.record import Record
    from flexros.robot import Robot

STEP_OF_TURN = 1e-4
"""Step of the derivatives to the offset of an encoder and to a rotation of the base [rad or m]."""
STEP = 1e-6
"""Relative step of the derivatives of the regression parameters to those of the robot [1]."""


def regress_torque(
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    arm: ArmTorque | None = None,
    *,
    load: Load = "none",
    delay: float = 0.0,
    position_torques: tuple[PositionTorque, ...] = (),
    uneven: bool = False,
    zeros: Mapping[int, float] = MappingProxyType({}),
    tilt: Mapping[str, float] = MappingProxyType({}),
    settings: TorqueStartSettings | None = None,
) -> TorqueRegression | None:
    """Regress the torques of a log on friction, motor inertias and tolerated parameters of the bodies.

    Args:
        record: The log.
        model: The nominal model, with no laws but Coulomb friction.
        tolerance: Parameters of the robot that may deviate.
        arm: What the arm takes from the motors; None for locked springs.
        load: Load that the last body that moves may carry, with locked springs. The tolerated parameters are nominal
            then: all bodies a little heavier look much like it.
        delay: Delay of the commands beyond that of the model [s]. Where positions are commanded, the torques are those
            of the servos, whose stiffness may be wrong too.
        position_torques: Further torques of motors over their own positions, such as those of a spring or a gas
            cylinder that carries the weight of the arm, or of a cable; their sizes are free.
        uneven: Whether viscous friction that differs by direction stands for the offset of every motor.
        zeros: Motors whose encoders may have another zero, with the offsets around which the torques are linear
            [rad or m]; behind springs around none.
        tilt: Axes about which the base may be turned, with the rotations around which the torques are linear [rad], as
            of `BaseTilt`; with locked springs.
        settings: Settings of the regression.

    Returns:
        The regression; None for a log in which no motor moves, or that is too short, for links that bend, and where
        the motion of the arm behind its springs ran away from that of the motors.
    """
    prepared = prepared_regression(
        record, model, tolerance, arm, load=load, delay=delay, zeros=zeros, tilt=tilt, settings=settings
    )
    return None if prepared is None else prepared.solved(position_torques, uneven=uneven)


@dataclass(frozen=True, eq=False)
class PreparedRegression:
    """Rows of a regression of the torques, to be solved with several sets of torques over position.

    Attributes:
        rows: The log.
        acting: The torques that act in it.
        sought: What is sought, without torques over position.
        slopes: Slopes of the torques, shape (n, M, k).
        torque: Torques beyond those of the nominal model [Nm or N], shape (n, M).
        settings: Settings of the regression.
    """

    rows: RegressionRows
    acting: ActingTorque
    sought: Sought
    slopes: FloatArray
    torque: FloatArray
    settings: TorqueStartSettings

    def solved(
        self, position_torques: tuple[PositionTorque, ...] = (), *, uneven: bool = False
    ) -> TorqueRegression | None:
        """Solve the regression; arguments and result as of `regress_torque`."""
        rows, sought = self.rows, replace(self.sought, position_torques=position_torques)
        own, others = np.split(self.slopes, [sought.of_motors.stop], axis=-1)
        own = _identifiable(own, rows, sought, uneven=uneven)
        b = self.torque - own[..., sought.of_kind("coulomb_friction")] @ sought.known
        further = (
            _of_position(rows, position_torques),
            _of_zeros(rows, sought),
            _of_tilt(rows, sought),
            _of_servos(rows, self.acting, sought),
        )
        A = np.concatenate([own, *further, others], axis=-1)
        silenced = ~rows.record.predicted  # a prescribed motion says nothing of its torque
        A[:, silenced], b[:, silenced] = 0.0, 0.0
        if not (np.isfinite(A).all() and np.isfinite(b).all()):  # the arm behind its springs ran away from the log
            return None
        silent = is_silent(np.sqrt(np.mean(b**2, axis=0)))
        A[:, silent], b[:, silent] = 0.0, 0.0
        solution = _with_point if sought.load == "point" else solve
        return solution(A, b, sought, self.settings)


def prepared_regression(
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    arm: ArmTorque | None = None,
    *,
    load: Load = "none",
    delay: float = 0.0,
    zeros: Mapping[int, float] = MappingProxyType({}),
    tilt: Mapping[str, float] = MappingProxyType({}),
    settings: TorqueStartSettings | None = None,
) -> PreparedRegression | None:
    """Set up the rows of `regress_torque`, whose arguments these are; None for a log that gives none."""
    settings, robot = settings or TorqueStartSettings(), model.robot
    acting = acting_torque(record, model, delay)
    zeros = dict(zeros) if arm is None else dict.fromkeys(zeros, 0.0)
    rows = torque_rows(at_zeros(record, zeros), upright(robot, tilt), acting)
    if rows is None:
        return None
    tolerance = tolerance if load == "none" else Tolerance()
    sought = Sought(
        robot=robot,
        known=_known_friction(model),
        moving=rows.motion.moving,
        position_torques=(),
        load=load,
        servos=record.command is not None and not all(gains_are_known(robot, name) for name in robot.joint_names),
        tolerated=len(tolerance.names),
        zeros=zeros,
        tilt=tilt,
    )
    A, b = _linear(rows, sought, tolerance, rigid=arm is None or load != "none")
    if arm is not None:
        A, b = _behind_springs(A, b, rows, arm)
    return PreparedRegression(rows, acting, sought, A, b, settings)


def at_zeros(record: Record, zeros: Mapping[int, float]) -> Record:
    """Return a log with positions less the offsets of encoders.

    Args:
        record: The log.
        zeros: Offsets by the index of the motor [rad or m].
    """
    if not any(zeros.values()):
        return record
    offsets = np.zeros(record.position.shape[1])
    offsets[list(zeros)] = list(zeros.values())
    return replace(record, position=record.position - offsets)


def upright(robot: Robot, tilt: Mapping[str, float]) -> Robot:
    """Return a robot under gravity as it acts in the frame of its base, that of the robot file where that stands right.

    Args:
        robot: The robot.
        tilt: Rotations of its base by axis [rad], as of `BaseTilt`.
    """
    return BaseTilt(**tilt).changed(robot, "base") if any(tilt.values()) else robot


def _linear(
    rows: RegressionRows, sought: Sought, tolerance: Tolerance, *, rigid: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the torques beyond those of the nominal model, and their slopes to what the model may lack.

    Args:
        rows: The log.
        sought: What is sought; here of motors and a load.
        tolerance: Parameters of the bodies that may deviate; they count for a rigid robot without a load.
        rigid: Whether its springs are locked; else the arm is no part of the nominal model here.

    Returns:
        Slopes, shape (n, M, k), and torques [Nm or N], shape (n, M).
    """
    robot = sought.robot
    names = [parameter.name for parameter in rows.regressor.parameters]
    nominal = np.array([parameter.nominal for parameter in rows.regressor.parameters])
    own: FloatArray = np.zeros((len(nominal), sought.of_motors.stop))
    for motor, name in enumerate(robot.joint_names):
        for kind in KINDS:
            own[names.index(f"{name}.{kind}"), sought.of_kind(kind).start + motor] = 1.0
    if sought.load == "body":
        own = np.hstack([own, _of_body(names, last_moved(robot), nominal)])
    elif sought.load == "point":
        own = np.hstack([own, _of_load(names, last_moved(robot))])
    elif rigid:
        own = np.hstack([own, _tolerated(robot, tolerance, nominal)])
    else:
        nominal = nominal * np.isin(names, [f"{name}.inertia" for name in robot.joint_names])
    blocks = [(H @ own, torque - H @ nominal) for H, torque in rows.blocks()]
    return np.concatenate([A for A, _ in blocks]), np.concatenate([b for _, b in blocks])


def _behind_springs(
    A: FloatArray, b: FloatArray, rows: RegressionRows, arm: ArmTorque
) -> tuple[FloatArray, FloatArray]:
    """Take the torque of the arm from the torques, and add its slopes to the tolerated parameters."""
    begin = len(arm.torque) - rows.record.n_samples
    b = b - rows.decimated(arm.torque[begin:])
    slopes = rows.decimated(arm.slopes[begin:].reshape(rows.record.n_samples, -1))
    return np.concatenate([A, slopes.reshape(*b.shape, -1)], axis=-1), b


def _identifiable(own: FloatArray, rows: RegressionRows, sought: Sought, *, uneven: bool) -> FloatArray:
    """Return the slopes to the numbers of the motors with one constant torque for each at most, shape (n, M, 4 M).

    In a motor that turns in one direction only Coulomb friction is a constant torque, and friction that differs by
    direction is viscous. As every motor has friction, it is the friction.

    Args:
        own: The slopes, with an offset of every motor.
        rows: The log.
        sought: What the columns are.
        uneven: Whether viscous friction that differs by direction stands for the offset.
    """
    own, offset = own.copy(), sought.of_kind("torque_offset")
    if uneven:
        speeds = rows.decimated(np.abs(rows.motion.velocity))
        own[..., offset] = speeds[:, :, None] * np.eye(speeds.shape[1])
    friction = np.einsum("nmm->nm", own[..., sought.of_kind("coulomb_friction")])
    for motor in np.flatnonzero(np.abs(friction.sum(axis=0)) > ONE_WAY * np.abs(friction).sum(axis=0)):
        own[:, motor, offset.start + motor] = 0.0
    for torque in sought.position_torques:
        if torque.span is not None:  # a curve has a constant part
            own[..., offset.start + torque.motor] = 0.0
    return own


def _of_position(rows: RegressionRows, torques: tuple[PositionTorque, ...]) -> FloatArray:
    """Return what the sizes of torques over position take from the motors, shape (n, M, sizes)."""
    columns: FloatArray = np.zeros((*rows.torque.shape, sum(one.n_sizes for one in torques)))
    if not torques:
        return columns
    position, begin = rows.decimated(bridged_motion(rows.record.position, rows.record.valid)), 0
    for one in torques:
        columns[:, one.motor, begin : begin + one.n_sizes] = -one.columns(position[:, one.motor])
        begin += one.n_sizes
    return columns


def _of_zeros(rows: RegressionRows, sought: Sought) -> FloatArray:
    """Return how the torques of the nominal bodies change with the offsets of encoders, shape (n, M, zeros)."""
    columns: FloatArray = np.zeros((*rows.torque.shape, len(sought.zeros)))
    for column, motor in enumerate(sought.zeros):
        moved = STEP_OF_TURN * np.eye(sought.robot.n_motors)[motor]
        columns[..., column] = rows.torque_of_turned(moved) / STEP_OF_TURN
    return columns


def _of_tilt(rows: RegressionRows, sought: Sought) -> FloatArray:
    """Return how the torques of the nominal bodies change with rotations of the base, shape (n, M, axes)."""
    columns: FloatArray = np.zeros((*rows.torque.shape, len(sought.tilt)))
    for column, (axis, before) in enumerate(sought.tilt.items()):
        turned = BaseTilt(**{**sought.tilt, axis: before + STEP_OF_TURN}).values(sought.robot, "base")
        columns[..., column] = rows.torque_of_turned(np.zeros(sought.robot.n_motors), turned) / STEP_OF_TURN
    return columns


def _of_servos(rows: RegressionRows, acting: ActingTorque, sought: Sought) -> FloatArray:
    """Return the torques that the stiffness of the servos takes from the motors, shape (n, M, M); none without."""
    if not sought.servos:
        return np.zeros((*rows.torque.shape, 0))
    return -rows.decimated(acting.springs[acting.begin :])[:, :, None] * np.eye(sought.robot.n_motors)


def _with_point(A: FloatArray, b: FloatArray, sought: Sought, settings: TorqueStartSettings) -> TorqueRegression:
    """Solve the regression with a load at a point, whose inertia follows from its mass and first moment.

    With mass m and first moment s its inertia at the joint is (s's E - s s') / m. That is linear where the load is
    nearly known, and as a homogeneous function of (m, s) it is its own derivative times (m, s).
    """
    inertias = A[..., -len(INERTIA_COMPONENTS) :]
    A = A[..., : -len(INERTIA_COMPONENTS)]
    found = solve(A, b, sought, settings)
    for _ in range(ROUNDS):
        before, turned = found.load.copy(), A.copy()
        before[0] = max(before[0], np.linalg.norm(before[1:]) / settings.farthest_load)
        if before[0] <= 0:
            break
        turned[..., -len(LOAD) :] += inertias @ _inertia_slopes(before)
        found = solve(turned, b, sought, settings)
        if np.allclose(found.load, before, rtol=1e-3, atol=1e-6):
            break
    return found


def _inertia_slopes(load: FloatArray) -> FloatArray:
    """Return the derivatives of the inertia of a point load at the joint to its mass and first moment, shape (6, 4)."""
    mass, moment = load[0], load[1:]
    tensor = moment @ moment * np.eye(3) - np.outer(moment, moment)
    slopes = [-tensor / mass**2]
    for axis in np.eye(3):
        mixed = np.outer(axis, moment)
        slopes.append((2 * moment @ axis * np.eye(3) - mixed - mixed.T) / mass)
    return np.array([[one[entry] for one in slopes] for entry in (ENTRIES[name] for name in INERTIA_COMPONENTS)])


def _known_friction(model: RobotWithEffects) -> FloatArray:
    """Return the Coulomb friction that a model has, shape (M,)."""
    there = {name: [law.effect for law in model.laws if law.location == name] for name in model.robot.joint_names}
    levels = [CoulombFriction().reductions(model.robot, name, laws)["level"] for name, laws in there.items()]
    return np.array(levels)


def only_coulomb(model: RobotWithEffects) -> bool:
    """Return whether a model has no laws but Coulomb friction alike in both directions, which a regression takes."""
    return all(isinstance(law.effect, CoulombFriction) and law.effect.asymmetry == 0 for law in model.laws)


def _of_load(names: list[str], body: str) -> FloatArray:
    """Return which regression parameters are the numbers of a load on a body and its inertia, shape (P, 10)."""
    numbers = (*LOAD, *(f"inertia_at_joint.{entry}" for entry in INERTIA_COMPONENTS))
    columns = np.zeros((len(names), len(numbers)))
    for column, name in enumerate(numbers):
        columns[names.index(f"{body}.{name}"), column] = 1.0
    return columns


def _of_body(names: list[str], body: str, nominal: FloatArray) -> FloatArray:
    """Return the regression parameters of a body, of which a payload error is a share, shape (P, 1)."""
    return (nominal * [name.startswith(f"{body}.") for name in names])[:, None]


def _tolerated(robot: Robot, tolerance: Tolerance, nominal: FloatArray) -> FloatArray:
    """Return how the regression parameters change per standard deviation of each tolerated one, shape (P, k)."""
    changes = np.zeros((len(nominal), len(tolerance.names)))
    for column, (name, deviation) in enumerate(zip(tolerance.names, tolerance.deviations, strict=True)):
        moved = standard_parameters(robot, numbers={name: robot.parameters[name].value * (1 + STEP)})
        values = np.array([parameter.nominal for parameter in moved])
        changes[:, column] = (values - nominal) / STEP * deviation
    return changes
