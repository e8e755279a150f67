"""Errors of the torques of a measured log, beside those of predicted positions.

A rigid arm that tracks a reference has prescribed accelerations, and what the model lacks shows in the torques: with
the measured motion q, the torque that a hypothesis needs is

    u = (H(q, q', q'') pi + f(q, q')) / g,

with the standard parameters pi of the robot (Moberg 2007, eq. 4.11), the torques f of laws at the motors and the gain g
of the torque; q is the position less the offset of its encoder. Errors of predicted positions are these errors divided
by the inertia, so that more inertia leaves less of any of them, and light joints outweigh all others. The errors of the
torques do not have this fault, but they show no springs, and of a delay only that it moves the torques.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.signal import lfilter, lfilter_zi

from flexros.compile.over_rows import over_rows
from flexros.effects.base_tilt import BaseTilt
from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.bristle_friction import AbstractBristleFriction
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.first_order_lag import AbstractFirstOrderLag
from flexros.effects.kinds.motor_law import AbstractMotorLaw, AbstractMotorTorque, MotorState
from flexros.gap.residuals.arm_law_torque import arm_law_torque
from flexros.gap.residuals.torque_rows import acting_torque, torque_rows
from flexros.identify.rigid.motion_estimate import decimate
from flexros.identify.rigid.standard_parameters import standard_parameters
from flexros.robot.parameters import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.prediction.predictor import Predictor
    from flexros.identify.rigid.motion_estimate import MotionEstimate
    from flexros.identify.rigid.regression_rows import RegressionRows
    from flexros.record.record import Record
    from flexros.robot import Robot

KEPT = 512
"""Torques of laws that are kept (chosen): those of the sets of parameters that a fit compares."""
PARTS = 64
"""Laws whose parts are kept (chosen): those of all laws of a hypothesis, and of a step of each parameter of shape."""
BODIES = 16
"""Torques of the bodies that are kept (chosen): many sets of parameters have the same ones of the robot."""
NORMAL = 1.4826
"""Standard deviation of normal numbers over the median of their magnitudes [1]."""


@dataclass(frozen=True, eq=False)
class TorqueErrors:
    """What the torques of a log need of a hypothesis.

    Attributes:
        robot: The nominal robot.
        regressor: H, low-passed and decimated, shape (m, M, P).
        torque: Torques in the same rows, after the delay [Nm or N], shape (m, M).
        rate: Their rates of change [Nm/s or N/s], shape (m, M).
        delay: Delay of the torques beyond that of the model [s]; that of a hypothesis is near it.
        known: Friction of the laws of the nominal model in the same rows [Nm or N], shape (m, M).
        deviation: Standard deviation of an error [Nm or N], shape (M,); infinite for a motor of prescribed
            motion.
        motion: Time [s], then positions, speeds, torques and torques in the gears of all motors [SI], shape
            (1 + 4 M, n).
        rows: The rows.
        factor: Decimation from the motion to the rows.
        counts: Decimated rows that count, shape (n_decimated,).
    """

    robot: Robot
    regressor: FloatArray
    torque: FloatArray
    rate: FloatArray
    delay: float
    known: FloatArray
    deviation: FloatArray
    motion: FloatArray
    rows: RegressionRows
    factor: int
    counts: BoolArray

    @property
    def size(self) -> int:
        """Number of errors."""
        return int(self.torque.size)

    @property
    def n_values(self) -> int:
        """Number of errors that count."""
        return int(np.isfinite(self.deviation).sum()) * len(self.torque)

    def acting_later(self, time: float) -> TorqueErrors:
        """Return the errors of torques that act later by some time [s] than the log has them."""
        return replace(self, delay=self.delay - time)

    @property
    def speed(self) -> FloatArray:
        """Speeds of all motors at the samples [rad/s or m/s], shape (n, M)."""
        M = self.robot.n_motors
        return self.motion[1 + M : 1 + 2 * M].T

    def with_more(self, torque: FloatArray) -> TorqueErrors:
        """Return the errors of a log in which further torques act.

        Args:
            torque: They at the samples [Nm or N], shape (n, M).
        """
        return replace(self, torque=self.torque + decimate(torque, self.factor)[self.counts])

    def errors(self, predictor: Predictor, thetas: FloatArray) -> FloatArray:
        """Compute the errors of a hypothesis over their standard deviation.

        Args:
            predictor: The hypothesis.
            thetas: Parameters, shape (n_fitted, sets).

        Returns:
            Errors, motors one after the other, shape (M m, sets).
        """
        return np.stack([self._of_one(predictor, theta) for theta in thetas.T], axis=-1)

    def usual(self, predictor: Predictor, theta: FloatArray) -> FloatArray:
        """Return how large the errors of a hypothesis usually are [Nm or N], shape (M,).

        They are those of most rows: where a joint sticks, its torque may be any within its friction. Zero for a motor
        of prescribed motion.

        Args:
            predictor: The hypothesis.
            theta: Its parameters, shape (n_fitted,).
        """
        errors = self._of_one(predictor, theta).reshape(-1, len(self.torque))
        deviation = np.where(np.isfinite(self.deviation), self.deviation, 0.0)
        return np.asarray(NORMAL * np.median(np.abs(errors), axis=1) * deviation)

    def _of_one(self, predictor: Predictor, theta: FloatArray) -> FloatArray:
        values, zeros = predictor.values(theta), tuple(predictor.encoder_offsets(theta).tolist())
        tilted = any(candidate.effect is BaseTilt for candidate in predictor.hypothesis)  # else gravity is as stated
        given = predictor.numbers(theta).items()
        numbers = {name: value for name, value in given if tilted or name not in GRAVITY}
        needed = self._rows_of_bodies(predictor.robot, tuple(numbers.items()), zeros).copy()
        gains, late = np.ones(self.robot.n_motors), np.full(self.robot.n_motors, -self.delay)
        lags, limits = dict[int, float](), dict[int, AbstractCommandLaw]()
        for candidate, sizes in zip(predictor.hypothesis, values, strict=True):
            if candidate.effect.delays_commands:
                late[candidate.motors(self.robot)] += sizes["time"]
            effect = candidate.placed(sizes).effect
            if isinstance(effect, AbstractArmLaw) and not effect.n_states:
                position = self._positions - np.array(zeros)
                needed += arm_law_torque(predictor.robot, effect, candidate.location, position, numbers)
            if not isinstance(effect, AbstractMotorLaw) or candidate.location not in self.robot.joint_names:
                continue
            motor = self.robot.joint_names.index(candidate.location)
            if isinstance(effect, AbstractFirstOrderLag):
                lags[motor] = lags.get(motor, 0.0) + effect.time_constant
            elif isinstance(effect, AbstractCommandLaw):
                gains[motor] *= effect.gain
                if effect.cuts_off:
                    limits[motor] = effect
            else:
                own = tuple(effect.parameter_values.values())
                needed[:, motor] += self._rows_of(type(effect), motor, own, zeros[motor])
        torque = self.torque - late * self.rate
        for motor in lags.keys() | limits.keys():
            torque[:, motor] = self._passed(motor, limits.get(motor), lags.get(motor, 0.0), float(late[motor]))
        errors: FloatArray = ((torque - needed / gains) / self.deviation).T.ravel()
        return errors

    @cached_property
    def _positions(self) -> FloatArray:
        """Positions of all motors in the rows [rad or m], shape (m, M)."""
        return decimate(self.motion[1 : 1 + self.robot.n_motors].T, self.factor)[self.counts]

    @cached_property
    def _rows_of_bodies(self) -> Callable[[Robot, tuple[tuple[str, float], ...], tuple[float, ...]], FloatArray]:
        """Function of the torque that a robot with other numbers and zeros needs, and its known friction, in rows."""

        def rows(robot: Robot, numbers: tuple[tuple[str, float], ...], zeros: tuple[float, ...]) -> FloatArray:
            values = np.array([one.nominal for one in standard_parameters(robot, numbers=dict(numbers))])
            needed: FloatArray = self.regressor @ values + self.known
            upright = all(value == robot.parameters[name].value for name, value in numbers if name in GRAVITY)
            if upright and not any(zeros):
                return needed
            return needed + self.rows.torque_of_turned(np.array(zeros), dict(numbers))

        return lru_cache(maxsize=BODIES)(rows)

    @cached_property
    def _passed(self) -> Callable[[int, AbstractCommandLaw | None, float, float], FloatArray]:
        """Function of a motor's torque within a limit, if any, behind a lag of first order and later by some time.

        In the rows, shape (m,).
        """

        def passed(motor: int, limit: AbstractCommandLaw | None, lag: float, late: float) -> FloatArray:
            time, torque = self.motion[[0, 1 + 2 * self.robot.n_motors + motor]]
            torque = torque if limit is None else limit.cut_off(torque)
            slow = 2 * lag / (time[1] - time[0])  # the bilinear transform has the delay of the lag exactly
            numerator, denominator = np.array([1.0, 1.0]) / (1 + slow), np.array([1.0, (1 - slow) / (1 + slow)])
            at_rest = lfilter_zi(numerator, denominator) * torque[0]
            behind = lfilter(numerator, denominator, torque, zi=at_rest)[0] if lag else torque
            return decimate(np.interp(time - late, time, behind), self.factor)[self.counts]

        return lru_cache(maxsize=KEPT)(passed)

    @cached_property
    def _rows_of(self) -> Callable[[type[AbstractMotorLaw], int, tuple[float, ...], float], FloatArray]:
        """Function of the torque that a motor needs against a law, in the rows; of many sets few laws differ."""
        return lru_cache(maxsize=KEPT)(self._law)

    def _law(
        self, kind: type[AbstractMotorLaw], motor: int, numbers: tuple[float, ...], zero: float = 0.0
    ) -> FloatArray:
        needed = _needed_torque(kind)
        if needed is None:
            return np.zeros(len(self.torque))
        shape = tuple(0.0 if size else number for number, size in zip(numbers, needed.sizes, strict=True))
        torque: FloatArray = self._parts_of(kind, motor, shape, zero) @ needed.monomials(numbers)
        return torque

    @cached_property
    def _parts_of(self) -> Callable[[type[AbstractMotorLaw], int, tuple[float, ...], float], FloatArray]:
        """Function of the parts of a law with the parameters of its shape, in the rows, shape (m, parts)."""
        M, robot = self.robot.n_motors, self.robot

        def parts(kind: type[AbstractMotorLaw], motor: int, shape: tuple[float, ...], zero: float) -> FloatArray:
            needed = _needed_torque(kind)
            assert needed is not None
            time, position, speed, torque, load = self.motion[[0, *(1 + row * M + motor for row in range(4))]]
            position = position - zero
            state = np.stack([time, position, robot.rotor_turns[motor] * position, speed, torque, load], axis=-1)
            viscous = robot.parameters[f"{robot.joint_names[motor]}.viscous_friction"].value
            (values,) = over_rows(needed.parts, state, np.tile([viscous, *shape], (len(state), 1)))
            return decimate(values, self.factor)[self.counts]

        return lru_cache(maxsize=PARTS)(parts)


def torque_errors(record: Record, model: RobotWithEffects, delay: float, deviation: FloatArray) -> TorqueErrors | None:
    """Prepare the errors of the torques of a log.

    Args:
        record: The log, of a robot without springs, with torques.
        model: The nominal model, with no laws but Coulomb friction.
        delay: Delay of the torques beyond that of the model [s].
        deviation: Standard deviation of an error of each motor [Nm or N], shape (M,).

    Returns:
        The errors; None where no motor moves or the log is too short.
    """
    acting = acting_torque(record, model, delay)
    rows = torque_rows(record, model.robot, acting)
    if rows is None:
        return None
    torque, motion, robot = acting.torque[acting.begin :], rows.motion, model.robot
    time = rows.record.begin + record.sample_time * np.arange(len(torque))
    whole = TorqueErrors(
        robot=robot,
        regressor=np.concatenate([H for H, _ in rows.blocks()]),
        torque=rows.torque,
        rate=rows.decimated(np.gradient(torque, record.sample_time, axis=0)),
        delay=delay,
        known=np.zeros_like(rows.torque),
        deviation=deviation,
        motion=np.vstack([time, motion.position.T, motion.velocity.T, torque.T, _in_gears(robot, motion)]),
        rows=rows,
        factor=rows.factor,
        counts=rows.counts,
    )
    for law in model.laws:
        if isinstance(law.effect, AbstractMotorLaw):
            motor, numbers = robot.joint_names.index(law.location), tuple(law.effect.parameter_values.values())
            whole.known[:, motor] += whole._rows_of(type(law.effect), motor, numbers, 0.0)
    return whole


def _in_gears(robot: Robot, motion: MotionEstimate) -> FloatArray:
    """Return the torques that the gears of a robot transmit to its arm in a motion [Nm or N], shape (M, n)."""
    arm = robot.arm_from_gears(np.eye(robot.n_motors))
    q, v, a = ((row @ arm).T for row in (motion.position, motion.velocity, motion.acceleration))
    model = robot.model
    torque = model.arm_inverse_dynamics(q, v, a, model.parameter_values)
    return np.asarray(torque, dtype=float)[list(robot.gear_rows)]


@dataclass(frozen=True)
class _Needed:
    """The torque that a law takes from a motor in a given motion: a polynomial of second degree in its sizes.

    A fit asks for the parts of the polynomial once for each set of the other parameters, those of its shape, and not
    for each set of all.

    Attributes:
        sizes: Whether a parameter is a size.
        parts: Torque per unit of each monomial, a function of (time, position, angle of the rotor, speed, torque,
            torque in the gear) and (nominal viscous friction, parameters with all sizes zero).
        squares: Which two sizes make each monomial of second degree.
    """

    sizes: tuple[bool, ...]
    parts: ca.Function
    squares: tuple[tuple[int, int], ...]

    def monomials(self, numbers: Sequence[float]) -> FloatArray:
        """Return the monomials of the sizes: 1, each size, and the products of two, half of those of one with itself.

        Args:
            numbers: The parameters.
        """
        sizes = [number for number, size in zip(numbers, self.sizes, strict=True) if size]
        return np.array([1.0, *sizes, *(sizes[j] * sizes[k] / (1 + (j == k)) for j, k in self.squares)])


@cache
def _needed_torque(kind: type[AbstractMotorLaw]) -> _Needed | None:
    """Build the torque that a law takes from a motor; None for one between command and motor.

    Bristles count as bent; own states that are not functions of time as zero. `feedforward.compensation.motors` adds
    the same torques to a planned motion, with signs that are smoothed and own states that are integrated.
    """
    effect = kind.model_construct()
    state, numbers = ca.SX.sym("state", 6), ca.SX.sym("numbers", 1 + len(effect.parameter_values))
    time, position, angle, speed, torque, load = ca.vertsplit(state)
    timed = len(effect.states_of_time(0.0))
    own = ca.vertcat(*[time] * timed, ca.SX.zeros(effect.n_states - timed))
    motor = MotorState(position, angle, speed, torque, own, numbers[0], load)
    values = dict(zip(effect.parameter_values, ca.vertsplit(numbers[1:]), strict=True))
    taken = []
    if isinstance(effect, AbstractDryFriction):
        levels = effect.levels(motor, values)
        against = ca.if_else(speed < 0, -levels.backward, levels.forward)
        taken.append(ca.if_else(speed == 0, 0, against))
    if isinstance(effect, AbstractBristleFriction):
        taken.append(ca.sign(speed) * effect.bristle(speed, values).level)
    if isinstance(effect, AbstractMotorTorque):
        taken.append(-effect.added(motor, values))
    if not taken:
        return None
    torque, own_numbers = ca.SX(sum(taken)), numbers[1:]
    chosen = _sizes_in(torque, own_numbers)
    sizes = own_numbers[chosen]
    curvature, slope = ca.hessian(torque, sizes)
    pairs = [(j, k) for k in range(len(chosen)) for j in range(k + 1) if not curvature[j, k].is_zero()]
    parts = ca.vertcat(torque, slope, *(curvature[j, k] for j, k in pairs))
    return _Needed(
        tuple(k in chosen for k in range(own_numbers.numel())),
        ca.Function("parts", [state, numbers], [ca.densify(parts)]),
        tuple(pairs),
    )


def _sizes_in(torque: ca.SX, numbers: ca.SX) -> list[int]:
    """Choose parameters of which a torque is a polynomial of second degree: the first ones that are together."""
    chosen: list[int] = []
    for k in range(numbers.numel()):
        if ca.is_quadratic(torque, numbers[[*chosen, k]]):
            chosen.append(k)
    return chosen
