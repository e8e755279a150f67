"""Compensation of effects in the gears: backlash, hysteresis, transmission error, nonlinear stiffness."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import casadi as ca
import numpy as np

from flexros.effects.kinds.gear_law import AbstractGearLaw, GearState
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.feedforward.motion import Motion
    from flexros.robot import Robot

SMOOTHING_TIME = 0.01
"""Duration over which a jump of the deflection, such as a backlash gap, is smoothed [s] (chosen): the motor torque
grows with the inverse square of it."""

ACCURACY, LEAST_WIDTH, MOST_ITERATIONS = 1e-13, 1e-6, 200
"""Solver of a deflection [rad or m]: accuracy, first search step in a loose gear, largest number of iterations."""

REST_PASSES = 5
"""Iterations to find initial states and deflection that are consistent at rest."""


def with_gear_laws(motion: Motion, robot: Robot, laws: Sequence[PlacedLaw], sample_time: float) -> Motion:
    """Change the motor motion such that the arm gets the same torques through gears with effects.

    The torque that the arm requires through each gear does not depend on the effects in the gear. For each sample two
    deflections that transmit it are solved: of the gear with laws and of the gear without. The motor moves by their
    difference, smoothed over `SMOOTHING_TIME` where the deflection can jump.

    Args:
        motion: The whole motion of the robot without the laws.
        robot: The robot.
        laws: Laws on it; those that are not in the gear of a motor are skipped, and so are all laws of a robot whose
            motors act on the arm in addition to their gears (inertial coupling).
        sample_time: Distance of the samples [s].

    Returns:
        The motion with the motor motion and torques for the gears with laws.
    """
    for number in () if robot.spec.inertial_coupling else robot.flexible_motors:
        own = [law.effect for law in laws if law.location in (robot.joint_names[number], _spring_name(robot, number))]
        effects = sorted(
            (effect for effect in own if isinstance(effect, AbstractGearLaw)), key=lambda effect: effect.rank
        )
        if effects and len(motion) > 1:
            motion = _Gear(robot, number, effects, sample_time).moved(motion)
    return motion


def _spring_name(robot: Robot, number: int) -> str:
    return robot.arm_names[robot.gear_rows[number]]


class _Gear:
    """A gear with laws, along a planned motion."""

    def __init__(self, robot: Robot, number: int, effects: Sequence[AbstractGearLaw], sample_time: float) -> None:
        joint = robot.motors[number].joint
        spring, numbers = joint.direction.spring, robot.parameters
        assert isinstance(spring, Spring)
        self._number, self._arm, self._effects, self._step = number, robot.gear_rows[number], effects, sample_time
        self._friction = numbers[f"motor_{number + 1}.viscous_friction"].value
        self._inertia = numbers[f"motor_{number + 1}.inertia"].value
        self._damping = numbers[f"{joint.name}.damping"].value
        self._spring = partial(spring.force, scale=numbers[f"{joint.name}.stiffness"].value)
        self._turns = float(robot.rotor_turns[number])
        self._jumps = any(effect.stepwise_states > 0 for effect in effects)
        self._make_functions()

    def moved(self, motion: Motion) -> Motion:
        """Return the motion with this motor's motion and torque changed."""
        m = self._number
        speed, arm = motion.motor_velocity[:, m], motion.arm_position[:, self._arm]
        required = motion.load[:, m] - self._friction * speed
        plain, _ = self._deflection(arm, required, laws=False)
        deflection, extra_torque = self._deflection(arm, required, laws=True)
        change = deflection - plain
        change = _smoothed(change, self._step) if self._jumps else change
        rate = np.gradient(change, self._step)
        load = extra_torque + self._friction * rate
        arrays = {name: getattr(motion, name).copy() for name in ("motor_position", "motor_velocity", "torque", "load")}
        momentum = motion.momentum.copy()
        arrays["motor_position"][:, m] += change
        arrays["motor_velocity"][:, m] += rate
        arrays["torque"][:, m] += self._inertia * np.gradient(rate, self._step) + load
        arrays["load"][:, m] += load
        momentum[:, m] += self._inertia * rate
        return replace(motion, momentum=momentum, **arrays)

    def _make_functions(self) -> None:
        """Build functions of y = [deflection, previous one, arm, previous one, required torque, own states]."""
        deflection, before, arm, arm_before, required = (ca.SX.sym(name) for name in ("d", "d_", "a", "a_", "u"))
        own = [ca.SX.sym("own", effect.n_states) for effect in self._effects]
        y = ca.vertcat(deflection, before, arm, arm_before, required, *own)
        rate = (deflection - before) / self._step
        gears, gear = [], self._nominal(deflection, rate, arm, (arm - arm_before) / self._step)
        for effect, states in zip(self._effects, own):  # each law acts on the spring as changed by the laws before it
            gears.append(replace(gear, own=states))
            gear = effect.onward(gears[-1], effect.parameter_values)
        added, extra_torque, following, at_rest = ca.SX(0), ca.SX(0), [ca.SX(0, 1)], [ca.SX(0, 1)]
        for effect, gear in zip(self._effects, gears):
            torques = effect.added(gear, effect.parameter_values)
            added, extra_torque = added + torques.arm, extra_torque - torques.arm - torques.motor
            following.append(self._next(effect, gear))
            at_rest.append(effect.rest(gear, effect.parameter_values))
        plain = self._spring(deflection) + self._damping * rate
        errors = [plain - required, plain + added - required]
        resting = [ca.substitute(error, before, deflection) for error in errors]
        self._y = np.zeros(y.numel())
        self._errors, self._resting = (
            [_Evaluator(ca.vertcat(error, ca.jacobian(error, deflection)), y, self._y) for error in row]
            for row in (errors, resting)
        )
        self._extra_torque = _Evaluator(extra_torque, y, self._y)
        self._following, self._rest = (_Evaluator(ca.vertcat(*row), y, self._y) for row in (following, at_rest))

    def _nominal(self, deflection: ca.SX, rate: ca.SX, arm: ca.SX, arm_speed: ca.SX) -> GearState:
        return GearState(
            deflection=deflection,
            rate=rate,
            angle=self._turns * (arm + deflection),
            motor_speed=arm_speed + rate,
            turns=self._turns,
            torque=self._spring(deflection) + self._damping * rate,
            damping=self._damping,
            spring=self._spring,
            own=ca.SX(0, 1),
        )

    def _next(self, effect: AbstractGearLaw, gear: GearState) -> ca.SX:
        """Return the own states at the next sample: continuous ones integrated, stepwise ones held through the step."""
        step = ca.SX(self._step)
        if effect.stepwise_states:
            after = effect.after_step(gear, effect.parameter_values, step)
            gear = replace(gear, own=ca.vertcat(*_rows(gear.own, effect.smooth_states), after))
        rates = _rows(effect.rates(gear, effect.parameter_values), effect.smooth_states)
        ahead = [row + step * rate for row, rate in zip(_rows(gear.own, effect.smooth_states), rates)]
        if effect.stepwise_states:
            ahead.append(effect.before_step(gear, effect.parameter_values, step))
        return ca.vertcat(ca.SX(0, 1), *ahead)

    def _deflection(self, arm: FloatArray, required: FloatArray, laws: bool) -> tuple[FloatArray, FloatArray]:
        """Solve for the deflection at every sample; return it and the additional motor torque due to the laws."""
        deflection, extra_torque = np.zeros(len(arm)), np.zeros(len(arm))
        y = self._y
        y[:] = 0.0
        y[2:5] = arm[0], arm[0], required[0]
        for _ in range(REST_PASSES):  # own states and deflection depend on each other
            y[:2] = _root(self._resting[laws], y)
            y[5:] = self._rest() if laws else 0.0
        error = self._errors[laws]
        for k in range(len(arm)):
            y[1:5] = y[0], arm[k], arm[max(k - 1, 0)], required[k]
            y[0] = deflection[k] = _root(error, y)
            if laws:
                extra_torque[k] = self._extra_torque()[0]
                y[5:] = self._following()
        return deflection, extra_torque


class _Evaluator:
    """A compiled function of an array that is bound once, for many calls without conversion.

    Args:
        value: Value of the function, SX column.
        argument: Its argument, SX column.
        array: Values of the argument; each call reads them.
    """

    def __init__(self, value: ca.SX, argument: ca.SX, array: FloatArray) -> None:
        self._result = np.zeros(value.numel())
        function = ca.Function("value", [argument], [ca.densify(value)], {"cse": True})
        self._buffer, self._evaluate = cast("tuple[Any, Callable[[], None]]", function.buffer())
        self._buffer.set_arg(0, memoryview(array.data))
        self._buffer.set_res(0, memoryview(self._result.data))

    def __call__(self) -> FloatArray:
        """Evaluate at the present values of the array; the next call overwrites the result."""
        if len(self._result):
            self._evaluate()
        return self._result


def _rows(column: ca.SX, count: int) -> list[ca.SX]:
    """Return the first entries of a column as a list."""
    return [column[i] for i in range(count)]


def _root(error: _Evaluator, y: FloatArray) -> float:
    """Find the deflection y[0] at which an increasing error is zero, by Newton's method safeguarded by a bracket."""
    low, high, deflection = -math.inf, math.inf, float(y[0])
    for _ in range(MOST_ITERATIONS):
        y[0] = deflection
        value, slope = error().tolist()
        if value == 0.0:  # in a gap without load every deflection is a solution: keep the present one
            return deflection
        low, high = (low, deflection) if value > 0 else (deflection, high)
        step = -value / slope if slope > 0 else math.copysign(math.inf, -value)
        if abs(step) <= ACCURACY:
            return deflection + step
        goal = deflection + step
        if not low <= goal <= high or not math.isfinite(goal):
            width = math.copysign(max(abs(deflection), LEAST_WIDTH), -value)
            goal = 0.5 * (low + high) if math.isfinite(high - low) else deflection + width
        deflection = goal
    return deflection


def _smoothed(values: FloatArray, sample_time: float) -> FloatArray:
    """Smooth values by three successive running means with a total length of `SMOOTHING_TIME`.

    The filter is symmetric. Beyond the ends the values are extended as constants.
    """
    half = max(1, round(SMOOTHING_TIME / sample_time / 6))
    window = np.ones(2 * half + 1) / (2 * half + 1)
    for _ in range(3):
        values = np.convolve(np.pad(values, half, mode="edge"), window, mode="valid")
    return values
