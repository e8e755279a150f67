"""Solution of a regression of torques, within physical bounds: each motor is weighted by what is left of its torque."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Literal, TypeVar

import numpy as np
from scipy.optimize import lsq_linear

from flexros.gap.candidates.tolerance import FARTHEST
from flexros.gap.fit.uncertainty.coloured_errors import coloured
from flexros.gap.fit.uncertainty.covariance import inverse_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.fit.torques.position_torque import PositionTorque
    from flexros.gap.settings import TorqueStartSettings
    from flexros.robot import Robot

FARTHEST_TURN = 0.5
"""Largest change of the offset of an encoder, or of a rotation of the base, in one linear solution [rad or m] (chosen):
beyond it a sine is none."""
ROUNDS = 8
"""Rounds in which each motor is weighted by what is left of its torque (chosen; few are needed)."""
UNSEEN = 1e-9
"""Norm of a column, over the largest one, below which rounding alone is left of it [1]."""
SILENT = 1e-9
"""Torque of a motor, over the largest one, up to which rounding alone is left of it [1] (chosen)."""
KINDS = ("inertia", "viscous_friction", "coulomb_friction", "torque_offset")
"""Columns of every motor."""
_Key = TypeVar("_Key", int, str)
Load = Literal["none", "body", "point"]
"""Load that the last body that moves may carry: none, a share of itself, or a mass at a point."""
LOAD = ("mass", "first_moment.x", "first_moment.y", "first_moment.z")
"""Columns of a load."""


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
        position_torques: Torques of motors over their own positions, with their sizes.
        zeros: Offsets of encoders by the index of their motor [rad or m]; empty without one.
        tilt: Rotations of the base by axis [rad], as of `BaseTilt`; empty without one.
        faint_inertia: Added inertia of every motor, also where it explains too little to stand out [kg m2 or kg],
            shape (M,).
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
    position_torques: tuple[PositionTorque, ...] = ()
    zeros: Mapping[int, float] = field(default_factory=dict)
    tilt: Mapping[str, float] = field(default_factory=dict)
    faint_inertia: FloatArray = field(default_factory=partial(np.zeros, 0))
    inertia_deviation: FloatArray = field(default_factory=partial(np.zeros, 0))


@dataclass(frozen=True, eq=False)
class Sought:
    """What a regression looks for, in the order of its columns.

    These are the kinds of every motor, sizes of torques over position, offsets of encoders, rotations of the base, a
    load or the stiffness of every servo, and tolerated parameters.

    Attributes:
        robot: The nominal robot.
        known: Coulomb friction that its model has [Nm or N], shape (M,).
        moving: Motors that move, shape (M,).
        position_torques: Torques of motors over their own positions.
        load: Load that the last body that moves may carry.
        servos: Whether the torques are those of servos, not all of which have known gains.
        tolerated: Number of tolerated parameters.
        zeros: Offsets around which those of encoders are sought, by the index of their motor [rad or m].
        tilt: Rotations around which those of the base are sought, by axis [rad].
    """

    robot: Robot
    known: FloatArray
    moving: BoolArray
    position_torques: tuple[PositionTorque, ...]
    load: Load
    servos: bool
    tolerated: int
    zeros: Mapping[int, float] = field(default_factory=dict)
    tilt: Mapping[str, float] = field(default_factory=dict)

    def of_kind(self, kind: str) -> slice:
        """Return the columns of one of `KINDS`."""
        begin = KINDS.index(kind) * self.robot.n_motors
        return slice(begin, begin + self.robot.n_motors)

    @property
    def of_motors(self) -> slice:
        """Columns of all kinds."""
        return slice(0, len(KINDS) * self.robot.n_motors)

    @property
    def of_position(self) -> slice:
        """Columns of the torques over position."""
        begin = self.of_motors.stop
        return slice(begin, begin + sum(one.n_sizes for one in self.position_torques))

    @property
    def of_zeros(self) -> slice:
        """Columns of the offsets of encoders."""
        return slice(self.of_position.stop, self.of_position.stop + len(self.zeros))

    @property
    def of_tilt(self) -> slice:
        """Columns of the rotations of the base."""
        return slice(self.of_zeros.stop, self.of_zeros.stop + len(self.tilt))

    @property
    def of_load(self) -> slice:
        """Columns of a load, or of the servos."""
        begin, of_load = self.of_tilt.stop, {"none": 0, "body": 1, "point": len(LOAD)}[self.load]
        return slice(begin, begin + (self.robot.n_motors if self.servos else of_load))

    @property
    def of_tolerance(self) -> slice:
        """Columns of tolerated parameters."""
        return slice(self.of_load.stop, self.of_load.stop + self.tolerated)

    @property
    def prior(self) -> FloatArray:
        """Root of the information of the prior: tolerated deviations are of size 1, shape (n_tolerated, k)."""
        return np.eye(self.of_tolerance.stop)[self.of_tolerance]

    def bounds(self, most_reduced: float) -> tuple[FloatArray, FloatArray]:
        """Return the lowest and highest physical value of every column, shape (k,) each.

        Args:
            most_reduced: Largest share of a nominal rotor inertia or servo stiffness that is taken away [1].
        """
        low, high = np.full((2, self.of_tolerance.stop), [[-np.inf], [np.inf]])
        low[self.of_kind("inertia")] = -most_reduced * self._numbers("inertia")
        low[self.of_kind("viscous_friction")] = -self._numbers("viscous_friction")
        low[self.of_kind("coulomb_friction")] = -self.known
        if self.servos:
            low[self.of_load] = -most_reduced
        elif self.load != "none":
            low[self.of_load.start] = 0.0  # its mass, or the share of the body
        for turned in (self.of_zeros, self.of_tilt):
            low[turned], high[turned] = -FARTHEST_TURN, FARTHEST_TURN
        low[self.of_tolerance], high[self.of_tolerance] = -FARTHEST, FARTHEST
        return low, high

    def _numbers(self, number: str) -> FloatArray:
        return np.array([self.robot.parameters[f"{name}.{number}"].value for name in self.robot.joint_names])


@dataclass(frozen=True, eq=False)
class _Solution:
    """Numbers that leave least.

    Attributes:
        values: The numbers, shape (k,).
        whole: Torque of every motor beyond the nominal model, rms [Nm or N], shape (M,); never zero.
        left: What is left of it, rms [Nm or N], shape (M,); never zero.
        free: Columns that are seen and whose number is not at a bound, shape (k,).
    """

    values: FloatArray
    whole: FloatArray
    left: FloatArray
    free: BoolArray


def solve(A: FloatArray, b: FloatArray, sought: Sought, settings: TorqueStartSettings) -> TorqueRegression:
    """Solve a regression of torques.

    Args:
        A: Slopes of the torques to what is sought, shape (n, M, k).
        b: Torques beyond those of the nominal model [Nm or N], shape (n, M).
        sought: What the columns are.
        settings: Settings of the regression.
    """
    found = _solution(A, b, sought, settings.most_reduced)
    # a column acts on its own motor alone, so that the diagonal of each kind is all of it
    size: FloatArray = np.sqrt(np.mean(A**2, axis=0)) * np.abs(found.values)
    shares = [settings.least_bias if kind == "torque_offset" else settings.least_share for kind in KINDS]
    clear = [_stands_out(size[:, sought.of_kind(kind)], share * found.left) for kind, share in zip(KINDS, shares)]
    own = np.where(np.stack(clear) & sought.moving, found.values[sought.of_motors].reshape(len(KINDS), -1), 0.0)
    inertia, viscous_friction, coulomb_friction, offset = own
    load, stiffness = np.zeros(len(LOAD)), np.zeros(sought.robot.n_motors)
    if sought.servos:
        stands_out = _stands_out(size[:, sought.of_load], settings.least_share * found.left)
        stiffness = np.where(stands_out & sought.moving, found.values[sought.of_load], 0.0)
    elif sought.load != "none":
        load = found.values[sought.of_load]
    return TorqueRegression(
        inertia=inertia,
        viscous_friction=viscous_friction,
        coulomb_friction=coulomb_friction,
        bias=-offset,
        deviations=found.values[sought.of_tolerance],
        left=found.left / found.whole,
        rest=found.left,
        load=load,
        servo_stiffness=stiffness,
        position_torques=_with_sizes(sought.position_torques, found.values[sought.of_position]),
        zeros=_moved(sought.zeros, found.values[sought.of_zeros]),
        tilt=_moved(sought.tilt, found.values[sought.of_tilt]),
        faint_inertia=np.where(sought.moving, found.values[sought.of_kind("inertia")], 0.0),
        inertia_deviation=_deviation(A, b, sought, found)[sought.of_kind("inertia")],
    )


def rest_of(regression: TorqueRegression) -> float:
    """Return the sum of the logarithms of what is left at the motors [1]."""
    return float(np.log(np.maximum(regression.rest, 1e-300)).sum())


def is_silent(torques: FloatArray) -> BoolArray:
    """Return at which motors nothing but rounding is left of the torques: resting ones, whose model has what they need.

    Weighed by what is left, they would hide all others.

    Args:
        torques: Rms of what is left [Nm or N], shape (M,); where it is zero at all motors, none hides another.
    """
    return np.asarray((torques <= SILENT * torques.max()) & (torques.max() > 0))


def _with_sizes(torques: tuple[PositionTorque, ...], sizes: FloatArray) -> tuple[PositionTorque, ...]:
    """Return torques over position with their sizes, which follow one another."""
    own = np.split(sizes, np.cumsum([one.n_sizes for one in torques])[:-1]) if torques else []
    return tuple(replace(one, sizes=tuple(found.tolist())) for one, found in zip(torques, own, strict=True))


def _moved(before: Mapping[_Key, float], changes: FloatArray) -> dict[_Key, float]:
    """Return numbers with their changes."""
    return {key: value + change for (key, value), change in zip(before.items(), changes.tolist(), strict=True)}


def _stands_out(size: FloatArray, least: FloatArray) -> BoolArray:
    """Return at which motors a number makes more than the least torque, shape (M,)."""
    return np.asarray(np.diag(size) > least)


def _solution(A: FloatArray, b: FloatArray, sought: Sought, most_reduced: float) -> _Solution:
    """Solve, weigh each motor by what is left of its torque, and solve again until that settles."""
    bounds = sought.bounds(most_reduced)
    whole = np.maximum(np.sqrt(np.mean(b**2, axis=0)), 1e-300)
    left = whole
    for _ in range(ROUNDS):
        values, free = _weighted(A / left[:, None], b / left, sought.prior, bounds)
        before, left = left, np.maximum(np.sqrt(np.mean((b - A @ values) ** 2, axis=0)), 1e-6 * whole)
        if np.allclose(left, before, rtol=1e-3):
            break
    return _Solution(values, whole, left, free)


def _weighted(
    A: FloatArray, b: FloatArray, prior: FloatArray, bounds: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, BoolArray]:
    """Solve with given weights; also return which columns are seen and have no number at a bound, shape (k,)."""
    tolerated, k = prior.shape
    rows, low, high = A.reshape(-1, k), *bounds
    norms = np.linalg.norm(rows, axis=0)
    unseen = norms < UNSEEN * norms.max()
    rows[:, unseen] = 0.0
    scale = np.where(unseen, 1.0, norms)
    scale[k - tolerated :] = 1.0
    matrix, right = np.vstack([rows / scale, prior]), np.concatenate([b.ravel(), np.zeros(tolerated)])
    # the triangular factor has the same solution and few rows
    root: FloatArray = np.asarray(np.linalg.qr(np.column_stack([matrix, right]), mode="r"))
    within = (np.minimum(low * scale, -1e-12), np.maximum(high * scale, 1e-12))
    solved = lsq_linear(root[:, :k], root[:, k], bounds=within, method="bvls")
    return solved.x / scale, (solved.active_mask == 0) & np.any(rows != 0, axis=0)


def _deviation(A: FloatArray, b: FloatArray, sought: Sought, found: _Solution) -> FloatArray:
    """Return the standard deviation of every number, shape (k,); infinite at a bound and where nothing is seen."""
    covariance = _covariance(A / found.left[:, None], (b - A @ found.values) / found.left, sought.prior, found.free)
    return np.where(found.free, np.sqrt(np.maximum(np.diag(covariance), 0.0)), np.inf)


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
