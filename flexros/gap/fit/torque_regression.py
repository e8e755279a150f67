"""Friction and motor inertia of all motors at once, by regression of the torque: where the search for causes begins.

With springs locked and speeds from the measured positions, the torque is linear in friction, in the inertias of the
motors and nearly in the parameters of the bodies (Moberg 2007, eq. 4.11 to 4.13). With springs, the torque that the arm
takes from the motors is added, which is nearly linear in the tolerated parameters. Unlike prediction errors it stays so
however far the nominal model is off, so one solution finds what every robot has: friction at all joints, and rotors
that the model lacks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import lsq_linear

from flexros.effects.coulomb_friction import CoulombFriction
from flexros.effects.left_out.tool_load import last_moved
from flexros.errors import InputError
from flexros.gap.candidates.candidate import coulomb_levels
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.prediction.predictor import FARTHEST
from flexros.identify.rigid.motion_estimate import decimate
from flexros.identify.rigid.record import torque_as_it_acts
from flexros.identify.rigid.regression_rows import RegressionRows
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.identify.rigid.standard_parameters import standard_parameters
from flexros.record.smoothing import motion_cutoff

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.arm_torque import ArmTorque
    from flexros.record.record import Record
    from flexros.robot import Robot

ROUNDS = 8
"""Rounds in which each motor is weighted by what is left of its torque (chosen; few are needed)."""
STEP = 1e-6
"""Relative step of the derivatives of the regression parameters to those of the robot [1]."""
LEAST_SHARE = 0.1
"""Contribution to the torque, over the rest at that motor, from which it is kept, rms [1] (chosen)."""
KINDS = ("inertia", "viscous_friction", "coulomb_friction", "torque_offset")
"""Columns of every motor."""
FEWEST = 2
"""Fewest samples after decimation, over the columns of a motor [1] (chosen)."""
LOAD = ("mass", "first_moment.x", "first_moment.y", "first_moment.z")
"""Columns of a load."""


@dataclass(frozen=True, eq=False)
class TorqueRegression:
    """What a rigid robot lacks, by the torques of a log.

    Attributes:
        inertia: Added inertia of every motor [kg m2 or kg], shape (M,).
        viscous_friction: Added viscous friction of every motor [Nm s/rad or N s/m], shape (M,).
        coulomb_friction: Added Coulomb friction of every motor [Nm or N], shape (M,).
        deviations: Tolerated deviations, in standard deviations [1], shape (n_tolerated,).
        left: Rest of the torque of every motor over that of the nominal model, rms [1], shape (M,).
        rest: Rest of the torque of every motor, rms [Nm or N], shape (M,).
        load: Mass [kg] and first moment [kg m] of a load on the last body that moves, shape (4,); zeros without one.
    """

    inertia: FloatArray
    viscous_friction: FloatArray
    coulomb_friction: FloatArray
    deviations: FloatArray
    left: FloatArray
    rest: FloatArray
    load: FloatArray


def regress_torque(
    record: Record, model: RobotWithEffects, tolerance: Tolerance, arm: ArmTorque | None = None, *, load: bool = False
) -> TorqueRegression | None:
    """Regress the torques of a log on friction, motor inertias and tolerated parameters of the bodies.

    Args:
        record: The log.
        model: The nominal model, with no laws but Coulomb friction.
        tolerance: Parameters of the robot that may deviate.
        arm: What the arm takes from the motors; None for locked springs.
        load: Whether the last body that moves may carry a load, with locked springs. The tolerated parameters are
            nominal then: all bodies a little heavier look much like it.

    Returns:
        The regression; None for a log in which no motor moves, or that is too short, and for links that bend.
    """
    robot, levels = model.robot, coulomb_levels(model.laws)
    known = np.array([levels.get(name, 0.0) for name in robot.joint_names])
    try:
        regressor = RigidRegressor(robot)
        rows = _rows(record, regressor)
    except InputError:
        return None
    if rows is None:
        return None
    names = [parameter.name for parameter in regressor.parameters]
    nominal = np.array([parameter.nominal for parameter in regressor.parameters])
    M = robot.n_motors
    own: FloatArray = np.zeros((len(nominal), len(KINDS) * M))
    for motor, name in enumerate(robot.joint_names):
        for kind, label in enumerate(KINDS):
            own[names.index(f"{name}.{label}"), kind * M + motor] = 1.0
    columns, errors = [], []
    if load:
        tolerance, own = Tolerance(), np.hstack([own, _of_load(names, last_moved(robot))])
    elif arm is None:
        own = np.hstack([own, _tolerated(robot, tolerance, nominal)])
    else:
        nominal = nominal * np.isin(names, [f"{name}.inertia" for name in robot.joint_names])
    for H, torque in rows.blocks():
        columns.append(H @ own)
        errors.append(torque - H @ nominal)
    A, b = np.concatenate(columns), np.concatenate(errors)
    if arm is not None:
        begin, factor = len(arm.torque) - rows.record.n_samples, rows.factor
        b = b - decimate(arm.torque[begin:], factor)[rows.counts]
        slopes = decimate(arm.slopes[begin:].reshape(rows.record.n_samples, -1), factor)[rows.counts]
        A = np.concatenate([A, slopes.reshape(*b.shape, -1)], axis=-1)
    column = KINDS.index("coulomb_friction") * M
    b = b - A[:, :, column : column + M] @ known
    return _solved(A, b, robot, known, len(tolerance.names), rows.motion.moving, LOAD if load else ())


def only_coulomb(model: RobotWithEffects) -> bool:
    """Return whether a model has no laws but Coulomb friction alike in both directions, which a regression takes."""
    return all(isinstance(law.effect, CoulombFriction) and law.effect.asymmetry == 0 for law in model.laws)


def _rows(record: Record, regressor: RigidRegressor) -> RegressionRows | None:
    """Filter and decimate a log; None where no motor moves or too few rows are left."""
    robot = regressor.robot
    acting, begin = torque_as_it_acts(record, 0.0 if record.measured_torque else robot.delay)
    part, every = record.part(begin, record.n_samples), tuple(range(len(regressor.parameters)))
    rows = RegressionRows.of_record(part, acting[begin:], motion_cutoff(record.sample_time), regressor, every)
    enough = len(rows.torque) >= FEWEST * len(KINDS)  # each has an equation for every motor
    return rows if enough and rows.motion.moving.any() else None


def _of_load(names: list[str], body: str) -> FloatArray:
    """Return which regression parameters are the numbers of a load on a body, shape (P, 4)."""
    columns = np.zeros((len(names), len(LOAD)))
    for column, name in enumerate(LOAD):
        columns[names.index(f"{body}.{name}"), column] = 1.0
    return columns


def _tolerated(robot: Robot, tolerance: Tolerance, nominal: FloatArray) -> FloatArray:
    """Return how the regression parameters change per standard deviation of each tolerated one, shape (P, k)."""
    changes = np.zeros((len(nominal), len(tolerance.names)))
    for column, (name, deviation) in enumerate(zip(tolerance.names, tolerance.deviations, strict=True)):
        moved = robot.with_values({name: robot.parameters[name].value * (1 + STEP)})
        values = np.array([parameter.nominal for parameter in standard_parameters(moved)])
        changes[:, column] = (values - nominal) / STEP * deviation
    return changes


def _solved(
    A: FloatArray,
    b: FloatArray,
    robot: Robot,
    known: FloatArray,
    tolerated: int,
    moving: BoolArray,
    load: tuple[str, ...],
) -> TorqueRegression:
    """Solve the regression within physical bounds, each motor weighted by what is left of its torque."""
    n, M, k = A.shape
    inertia = np.array([robot.parameters[f"{name}.inertia"].value for name in robot.joint_names])
    viscous = np.array([robot.parameters[f"{name}.viscous_friction"].value for name in robot.joint_names])
    endless = np.full(M, np.inf)
    carried = np.full(len(load), np.inf)
    lightest = np.where([name == "mass" for name in load], 0.0, -carried)
    low = np.concatenate([-0.9 * inertia, -viscous, -known, -endless, lightest, np.full(tolerated, -FARTHEST)])
    high = np.concatenate([endless, endless, endless, endless, carried, np.full(tolerated, FARTHEST)])
    prior = np.hstack([np.zeros((tolerated, k - tolerated)), np.eye(tolerated)])
    before = np.sqrt(np.mean(b**2, axis=0))
    left, solution = np.maximum(before, 1e-300), np.zeros(k)
    for _ in range(ROUNDS):
        rows, errors = (A / left[:, None]).reshape(n * M, k), (b / left).ravel()
        scale = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        scale[k - tolerated :] = 1.0
        matrix, right = np.vstack([rows / scale, prior]), np.concatenate([errors, np.zeros(tolerated)])
        # the triangular factor has the same solution and few rows
        root: FloatArray = np.asarray(np.linalg.qr(np.column_stack([matrix, right]), mode="r"))
        bounds = (np.minimum(low * scale, -1e-12), np.maximum(high * scale, 1e-12))
        solution = lsq_linear(root[:, :k], root[:, k], bounds=bounds, method="bvls").x / scale
        rest = np.sqrt(np.mean((b - A @ solution) ** 2, axis=0))
        used, left = left, np.maximum(rest, 1e-6 * np.maximum(before, 1e-300))
        if np.allclose(left, used, rtol=1e-3):
            break
    # a column acts on its own motor alone, so that the diagonal of each kind is all of it
    size: FloatArray = np.sqrt(np.mean(A**2, axis=0)) * np.abs(solution)
    own = np.stack([np.diag(size[:, kind * M : (kind + 1) * M]) for kind in range(3)])
    values = np.where((own > LEAST_SHARE * left) & moving, solution[: 3 * M].reshape(3, M), 0.0)
    inertias, viscous_friction, coulomb_friction = values
    shares = left / np.maximum(before, 1e-300)
    begin, end = len(KINDS) * M, len(KINDS) * M + len(load)
    found = solution[begin:end] if load else np.zeros(len(LOAD))
    return TorqueRegression(inertias, viscous_friction, coulomb_friction, solution[end:], shares, left, found)
