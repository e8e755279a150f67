"""Friction and motor inertia of all motors at once, by regression of the torque: where the search for causes begins.

With springs locked and speeds from the measured positions, the torque is linear in friction, in the inertias of the
motors and nearly in the parameters of the bodies (Moberg 2007, eq. 4.11 to 4.13). With springs, the torque that the arm
takes from the motors is added, which is nearly linear in the tolerated parameters. Unlike prediction errors it stays so
however far the nominal model is off, so one solution finds what every robot has: friction at all joints, and rotors
that the model lacks.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.optimize import lsq_linear

from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.left_out.tool_load import ENTRIES, last_moved
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.estimates import coloured, inverse_of
from flexros.gap.prediction.predictor import FARTHEST
from flexros.gap.residuals.torque_rows import acting_torque, torque_rows
from flexros.gap.settings import TorqueStartSettings
from flexros.identify.rigid.standard_parameters import standard_parameters
from flexros.record.missing_samples import bridged_motion
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.arm_torque import ArmTorque
    from flexros.identify.rigid.regression_rows import RegressionRows
    from flexros.record.record import Record
    from flexros.robot import Robot

ROUNDS = 8
"""Rounds in which each motor is weighted by what is left of its torque (chosen; few are needed)."""
STEP = 1e-6
"""Relative step of the derivatives of the regression parameters to those of the robot [1]."""
KINDS = ("inertia", "viscous_friction", "coulomb_friction", "torque_offset")
"""Columns of every motor."""
ONE_WAY = 0.96
"""Mean direction of a motion from which it is in one direction only [1] (chosen): less than 2 % of it is back."""
UNSEEN = 1e-9
"""Norm of a column, over the largest one, below which rounding alone is left of it [1]."""
Load = Literal["none", "body", "point"]
"""Load that the last body that moves may carry: none, a share of itself, or a mass at a point."""
LOAD = ("mass", "first_moment.x", "first_moment.y", "first_moment.z")
"""Columns of a load."""
BALANCE = ("cosine", "sine")
"""Columns of a counterbalance: its torques at positions 0 and 90 degrees."""


@dataclass(frozen=True, eq=False)
class TorqueRegression:
    """What a rigid robot lacks, by the torques of a log.

    Attributes:
        inertia: Added inertia of every motor [kg m2 or kg], shape (M,).
        viscous_friction: Added viscous friction of every motor [Nm s/rad or N s/m], shape (M,).
        coulomb_friction: Added Coulomb friction of every motor [Nm or N], shape (M,).
        bias: Added constant torque of every motor [Nm or N], shape (M,).
        deviations: Tolerated deviations, in standard deviations [1], shape (n_tolerated,).
        left: Rest of the torque of every motor over that of the nominal model, rms [1], shape (M,).
        rest: Rest of the torque of every motor, rms [Nm or N], shape (M,).
        load: Mass [kg] and first moment [kg m] of a load on the last body that moves, shape (4,); zeros without one.
        servo_stiffness: Relative error of the stiffness of every servo [1], shape (M,); zeros where torques are known.
        balance: Numbers of a counterbalance [Nm], shape (2,), by the index of its motor; empty without one.
        inertia_deviation: Standard deviation of the added inertias [kg m2 or kg], shape (M,): of coloured errors, and
            of what bodies within their tolerance have in common with rotors; infinite where it is none.
    """

    inertia: FloatArray
    viscous_friction: FloatArray
    coulomb_friction: FloatArray
    bias: FloatArray
    deviations: FloatArray
    left: FloatArray
    rest: FloatArray
    load: FloatArray
    servo_stiffness: FloatArray
    balance: Mapping[int, FloatArray] = field(default_factory=dict)
    inertia_deviation: FloatArray = field(default_factory=partial(np.zeros, 0))


def regress_torque(
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    arm: ArmTorque | None = None,
    *,
    load: Load = "none",
    delay: float = 0.0,
    balanced: int | None = None,
    uneven: bool = False,
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
        balanced: Index of a motor with a further torque over its own position, such as that of a spring or a gas
            cylinder that carries the weight of the arm; its first harmonic is free. None for none.
        uneven: Whether viscous friction that differs by direction stands for the offset of every motor.
        settings: Settings of the regression.

    Returns:
        The regression; None for a log in which no motor moves, or that is too short, for links that bend, and where
        the motion of the arm behind its springs ran away from that of the motors.
    """
    settings = settings or TorqueStartSettings()
    robot, known = model.robot, _known_friction(model)
    acting = acting_torque(record, model, delay)
    rows = torque_rows(record, robot, acting)
    if rows is None:
        return None
    if load != "none":
        tolerance = Tolerance()
    A, b = _linear(rows, robot, tolerance, load, rigid=arm is None or load != "none")
    if arm is not None:
        begin = len(arm.torque) - rows.record.n_samples
        b = b - rows.decimated(arm.torque[begin:])
        slopes = rows.decimated(arm.slopes[begin:].reshape(rows.record.n_samples, -1))
        A = np.concatenate([A, slopes.reshape(*b.shape, -1)], axis=-1)
    M = robot.n_motors
    if uneven:
        speeds = rows.decimated(np.abs(rows.motion.velocity))
        A[:, :, KINDS.index("torque_offset") * M : len(KINDS) * M] = speeds[:, :, None] * np.eye(M)
    for motor in _one_way(A, M):
        A[:, motor, KINDS.index("torque_offset") * M + motor] = 0.0
    lightest = np.where([name == "mass" for name in LOAD], 0.0, -np.inf)[: {"none": 0, "body": 1, "point": 4}[load]]
    if record.command is not None:
        springs = rows.decimated(acting.springs[acting.begin :])
        A = np.insert(A, [len(KINDS) * M] * M, -springs[:, :, None] * np.eye(M), axis=-1)
        lightest = np.full(M, -settings.most_reduced)
    column = KINDS.index("coulomb_friction") * M
    b = b - A[:, :, column : column + M] @ known
    if balanced is not None:
        position = rows.decimated(bridged_motion(rows.record.position, rows.record.valid))
        A = np.insert(A, [len(KINDS) * M] * len(BALANCE), _of_balance(position, balanced), axis=-1)
        lightest = np.concatenate([np.full(len(BALANCE), -np.inf), lightest])
    A[:, ~record.predicted], b[:, ~record.predicted] = 0.0, 0.0  # a prescribed motion says nothing of its torque
    if not (np.isfinite(A).all() and np.isfinite(b).all()):  # the arm behind its springs ran away from the log
        return None
    solved = partial(
        _solved,
        robot=robot,
        known=known,
        moving=rows.motion.moving,
        lightest=lightest,
        balanced=balanced,
        settings=settings,
    )
    if load == "point":
        return _with_point(A, b, solved, settings.farthest_load)
    return solved(A, b, tolerated=len(tolerance.names))


def _linear(
    rows: RegressionRows, robot: Robot, tolerance: Tolerance, load: Load, *, rigid: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the torques beyond those of the nominal model, and their slopes to what the model may lack.

    Args:
        rows: The log.
        robot: The nominal robot.
        tolerance: Parameters of the bodies that may deviate; they count for a rigid robot without a load.
        load: Load that the last body that moves may carry.
        rigid: Whether its springs are locked; else the arm is no part of the nominal model here.

    Returns:
        Slopes, shape (n, M, k), and torques [Nm or N], shape (n, M).
    """
    names = [parameter.name for parameter in rows.regressor.parameters]
    nominal = np.array([parameter.nominal for parameter in rows.regressor.parameters])
    own: FloatArray = np.zeros((len(nominal), len(KINDS) * robot.n_motors))
    for motor, name in enumerate(robot.joint_names):
        for kind, label in enumerate(KINDS):
            own[names.index(f"{name}.{label}"), kind * robot.n_motors + motor] = 1.0
    if load == "body":
        own = np.hstack([own, _of_body(names, last_moved(robot), nominal)])
    elif load == "point":
        own = np.hstack([own, _of_load(names, last_moved(robot))])
    elif rigid:
        own = np.hstack([own, _tolerated(robot, tolerance, nominal)])
    else:
        nominal = nominal * np.isin(names, [f"{name}.inertia" for name in robot.joint_names])
    blocks = [(H @ own, torque - H @ nominal) for H, torque in rows.blocks()]
    return np.concatenate([A for A, _ in blocks]), np.concatenate([b for _, b in blocks])


def _one_way(A: FloatArray, n_motors: int) -> IntArray:
    """List the motors that turn in one direction only.

    Coulomb friction is a constant torque there, and friction that differs by direction is viscous. As every motor has
    friction, it is the friction.
    """
    first = KINDS.index("coulomb_friction") * n_motors
    friction = np.einsum("nmm->nm", A[:, :, first : first + n_motors])
    return np.flatnonzero(np.abs(friction.sum(axis=0)) > ONE_WAY * np.abs(friction).sum(axis=0))


def _of_balance(position: FloatArray, motor: int) -> FloatArray:
    """Return the torques that both numbers of a counterbalance take from its motor, shape (n, M, 2)."""
    columns: FloatArray = np.zeros((*position.shape, len(BALANCE)))
    columns[:, motor] = -np.stack([np.cos(position[:, motor]), np.sin(position[:, motor])], axis=-1)
    return columns


def _with_point(
    A: FloatArray, b: FloatArray, solved: Callable[..., TorqueRegression], farthest: float
) -> TorqueRegression:
    """Solve the regression with a load at a point, whose inertia follows from its mass and first moment.

    With mass m and first moment s its inertia at the joint is (s's E - s s') / m. That is linear where the load is
    nearly known, and as a homogeneous function of (m, s) it is its own derivative times (m, s).
    """
    inertias = A[..., -len(INERTIA_COMPONENTS) :]
    A = A[..., : -len(INERTIA_COMPONENTS)]
    found = solved(A, b, tolerated=0)
    for _ in range(ROUNDS):
        before, turned = found.load.copy(), A.copy()
        before[0] = max(before[0], np.linalg.norm(before[1:]) / farthest)
        if before[0] <= 0:
            break
        turned[..., -len(LOAD) :] += inertias @ _inertia_slopes(before)
        found = solved(turned, b, tolerated=0)
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


def _solved(
    A: FloatArray,
    b: FloatArray,
    *,
    robot: Robot,
    known: FloatArray,
    tolerated: int,
    moving: BoolArray,
    lightest: FloatArray,
    balanced: int | None,
    settings: TorqueStartSettings,
) -> TorqueRegression:
    """Solve the regression within physical bounds, each motor weighted by what is left of its torque.

    Between the columns of the motors and those of tolerated parameters stand those of a counterbalance, then those of a
    load or of servos, with their lower bounds `lightest`.
    """
    n, M, k = A.shape
    inertia = np.array([robot.parameters[f"{name}.inertia"].value for name in robot.joint_names])
    viscous = np.array([robot.parameters[f"{name}.viscous_friction"].value for name in robot.joint_names])
    endless = np.full(M, np.inf)
    carried = np.full(len(lightest), np.inf)
    lost = settings.most_reduced
    low = np.concatenate([-lost * inertia, -viscous, -known, -endless, lightest, np.full(tolerated, -FARTHEST)])
    high = np.concatenate([endless, endless, endless, endless, carried, np.full(tolerated, FARTHEST)])
    prior = np.hstack([np.zeros((tolerated, k - tolerated)), np.eye(tolerated)])
    before = np.sqrt(np.mean(b**2, axis=0))
    left, solution = np.maximum(before, 1e-300), np.zeros(k)
    for _ in range(ROUNDS):
        rows, errors = (A / left[:, None]).reshape(n * M, k), (b / left).ravel()
        norms = np.linalg.norm(rows, axis=0)
        rows[:, norms < UNSEEN * norms.max()] = 0.0
        scale = np.where(norms < UNSEEN * norms.max(), 1.0, norms)
        scale[k - tolerated :] = 1.0
        matrix, right = np.vstack([rows / scale, prior]), np.concatenate([errors, np.zeros(tolerated)])
        # the triangular factor has the same solution and few rows
        root: FloatArray = np.asarray(np.linalg.qr(np.column_stack([matrix, right]), mode="r"))
        bounds = (np.minimum(low * scale, -1e-12), np.maximum(high * scale, 1e-12))
        solved = lsq_linear(root[:, :k], root[:, k], bounds=bounds, method="bvls")
        solution = solved.x / scale
        rest = np.sqrt(np.mean((b - A @ solution) ** 2, axis=0))
        used, left = left, np.maximum(rest, 1e-6 * np.maximum(before, 1e-300))
        if np.allclose(left, used, rtol=1e-3):
            break
    # a column acts on its own motor alone, so that the diagonal of each kind is all of it
    size: FloatArray = np.sqrt(np.mean(A**2, axis=0)) * np.abs(solution)
    own = np.stack([np.diag(size[:, kind * M : (kind + 1) * M]) for kind in range(len(KINDS))])
    least = np.where([kind == "torque_offset" for kind in KINDS], settings.least_bias, settings.least_share)[:, None]
    values = np.where((own > least * left) & moving, solution[: len(KINDS) * M].reshape(-1, M), 0.0)
    inertias, viscous_friction, coulomb_friction, offsets = values
    shares = left / np.maximum(before, 1e-300)
    between, end = len(KINDS) * M, len(KINDS) * M + len(lightest)
    begin = between + (0 if balanced is None else len(BALANCE))
    balance = {} if balanced is None else {balanced: solution[between:begin]}
    found, servos = solution[begin:end], end - begin == M and bool(np.all(lightest == -lost))
    load, stiffness = (np.zeros(len(LOAD)), found) if servos else (found, np.zeros(M))
    if servos:
        stiffness = np.where((np.diag(size[:, begin:end]) > settings.least_share * left) & moving, stiffness, 0.0)
    free = (solved.active_mask == 0) & np.any(rows != 0, axis=0)
    covariance = _covariance(A / left[:, None], (b - A @ solution) / left, prior, free)
    uncertain = np.where(free[:M], np.sqrt(np.maximum(np.diag(covariance)[:M], 0.0)), np.inf)
    return TorqueRegression(
        inertias,
        viscous_friction,
        coulomb_friction,
        -offsets,
        solution[end:],
        shares,
        left,
        load,
        stiffness,
        balance,
        uncertain,
    )


def _covariance(A: FloatArray, errors: FloatArray, prior: FloatArray, free: BoolArray) -> FloatArray:
    """Return the covariance of a solution, with errors of the colour of what is left (White 1980), shape (k, k).

    Args:
        A: Columns over what is left at each motor [1], shape (n, M, k).
        errors: What is left, over the same [1], shape (n, M).
        prior: Root of the information of the prior, shape (k_tolerated, k).
        free: Columns whose number is not at a bound, shape (k,); the others do not vary.
    """
    A, prior = A[:, :, free], prior[:, free]
    of_prior = prior.T @ prior
    information, meat = of_prior.copy(), of_prior.copy()
    for motor in range(A.shape[1]):
        J = A[:, motor]
        information += J.T @ J
        meat += coloured(J, errors[:, [motor]], len(J))
    inverse = inverse_of(information)
    covariance: FloatArray = np.zeros((len(free), len(free)))
    covariance[np.ix_(free, free)] = inverse @ meat @ inverse
    return covariance
