"""Making up for effects in the gears: backlash, hysteresis, transmission error, nonlinear stiffness."""

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
"""Time over which the motor is led through a jump of the deflection, such as the gap of a backlash [s] (chosen): the
torque for it grows with the inverse square of this time."""

ACCURACY, LEAST_WIDTH, MOST_ITERATIONS = 1e-13, 1e-6, 200
"""Of a deflection [rad or m]: accuracy, first step of a search where the gear is loose, and most iterations."""

REST_PASSES = 5
"""Passes to find a rest in which own states and deflection agree."""


def with_gear_laws(motion: Motion, robot: Robot, laws: Sequence[PlacedLaw], sample_time: float) -> Motion:
    """Move the motors such that the arm gets the same torques through gears with effects.

    The arm needs a torque through each gear, whatever is in the gear. So from sample to sample the deflection is sought
    at which spring, damper and laws together transmit it, and that of the gear without laws; the motor moves by the
    difference of the two, led through jumps in `SMOOTHING_TIME`.

    Args:
        motion: The whole motion of the robot without the laws.
        robot: The robot.
        laws: Laws on it; those that are none of a motor's gear are passed over, and all of a robot whose motors act on
            the arm beside their gears (inertial coupling).
        sample_time: Distance of the samples [s].

    Returns:
        The motion of the motors with the torques that it takes.
    """
    for number in () if robot.spec.inertial_coupling else robot.flexible_motors:
        own = [law.effect for law in laws if law.location in (robot.joint_names[number], _spring_name(robot, number))]
        effects = sorted((one for one in own if isinstance(one, AbstractGearLaw)), key=lambda effect: effect.rank)
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
        """Return the motion with that of this motor changed."""
        m = self._number
        speed, arm = motion.motor_velocity[:, m], motion.arm_position[:, self._arm]
        needed = motion.load[:, m] - self._friction * speed
        plain, _ = self._followed(arm, needed, laws=False)
        deflection, beside = self._followed(arm, needed, laws=True)
        change = deflection - plain
        change = _smoothed(change, self._step) if self._jumps else change
        rate = np.gradient(change, self._step)
        load = beside + self._friction * rate
        arrays = {name: getattr(motion, name).copy() for name in ("motor_position", "motor_velocity", "torque", "load")}
        momentum = motion.momentum.copy()
        arrays["motor_position"][:, m] += change
        arrays["motor_velocity"][:, m] += rate
        arrays["torque"][:, m] += self._inertia * np.gradient(rate, self._step) + load
        arrays["load"][:, m] += load
        momentum[:, m] += self._inertia * rate
        return replace(motion, momentum=momentum, **arrays)

    def _make_functions(self) -> None:
        """Make functions of y = [deflection, the one before, arm, the one before, torque needed, own states]."""
        deflection, before, arm, arm_before, needed = (ca.SX.sym(name) for name in ("d", "d_", "a", "a_", "needed"))
        own = [ca.SX.sym("own", effect.n_states) for effect in self._effects]
        y = ca.vertcat(deflection, before, arm, arm_before, needed, *own)
        rate = (deflection - before) / self._step
        gears, gear = [], self._nominal(deflection, rate, arm, (arm - arm_before) / self._step)
        for effect, states in zip(self._effects, own):  # each law sees what those before it made of the spring
            gears.append(replace(gear, own=states))
            gear = effect.onward(gears[-1], effect.parameter_values)
        added, beside, following, at_rest = ca.SX(0), ca.SX(0), [ca.SX(0, 1)], [ca.SX(0, 1)]
        for effect, gear in zip(self._effects, gears):
            torques = effect.added(gear, effect.parameter_values)
            added, beside = added + torques.arm, beside - torques.arm - torques.motor
            following.append(self._next(effect, gear))
            at_rest.append(effect.rest(gear, effect.parameter_values))
        plain = self._spring(deflection) + self._damping * rate
        errors = [plain - needed, plain + added - needed]
        resting = [ca.substitute(error, before, deflection) for error in errors]
        self._y = np.zeros(y.numel())
        self._errors, self._resting = (
            [_Evaluator(ca.vertcat(one, ca.jacobian(one, deflection)), y, self._y) for one in row]
            for row in (errors, resting)
        )
        self._beside = _Evaluator(beside, y, self._y)
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
        """Own states at the next sample: after the step that ends here, then those that are held through the next."""
        step = ca.SX(self._step)
        if effect.stepwise_states:
            after = effect.after_step(gear, effect.parameter_values, step)
            gear = replace(gear, own=ca.vertcat(*_rows(gear.own, effect.smooth_states), after))
        rates = _rows(effect.rates(gear, effect.parameter_values), effect.smooth_states)
        ahead = [row + step * rate for row, rate in zip(_rows(gear.own, effect.smooth_states), rates)]
        if effect.stepwise_states:
            ahead.append(effect.before_step(gear, effect.parameter_values, step))
        return ca.vertcat(ca.SX(0, 1), *ahead)

    def _followed(self, arm: FloatArray, needed: FloatArray, laws: bool) -> tuple[FloatArray, FloatArray]:
        """Find the deflection at every sample, and the torque that the laws take from the motor beside that."""
        deflection, beside = np.zeros(len(arm)), np.zeros(len(arm))
        y = self._y
        y[:] = 0.0
        y[2:5] = arm[0], arm[0], needed[0]
        for _ in range(REST_PASSES):  # own states and deflection depend on each other
            y[:2] = _root(self._resting[laws], y)
            y[5:] = self._rest() if laws else 0.0
        error = self._errors[laws]
        for k in range(len(arm)):
            y[1:5] = y[0], arm[k], arm[max(k - 1, 0)], needed[k]
            y[0] = deflection[k] = _root(error, y)
            if laws:
                beside[k] = self._beside()[0]
                y[5:] = self._following()
        return deflection, beside


class _Evaluator:
    """A function whose argument lies in an array that stays in place, for many calls.

    Args:
        value: What is evaluated, SX column.
        argument: Its argument, SX column.
        array: Numbers of the argument.
    """

    def __init__(self, value: ca.SX, argument: ca.SX, array: FloatArray) -> None:
        self._result = np.zeros(value.numel())
        function = ca.Function("value", [argument], [ca.densify(value)], {"cse": True})
        self._buffer, self._evaluate = cast("tuple[Any, Callable[[], None]]", function.buffer())
        self._buffer.set_arg(0, memoryview(array.data))
        self._buffer.set_res(0, memoryview(self._result.data))

    def __call__(self) -> FloatArray:
        """Evaluate at the present numbers; the result is overwritten by the next call."""
        if len(self._result):
            self._evaluate()
        return self._result


def _rows(column: ca.SX, count: int) -> list[ca.SX]:
    """First entries of a column, one by one."""
    return [column[place] for place in range(count)]


def _root(error: _Evaluator, y: FloatArray) -> float:
    """Find the deflection, the first of y, at which an error that rises with it is zero: Newton, kept in a bracket."""
    low, high, here = -math.inf, math.inf, float(y[0])
    for _ in range(MOST_ITERATIONS):
        y[0] = here
        value, slope = error().tolist()
        if value == 0.0:  # anywhere in a gap without load, so here
            return here
        low, high = (low, here) if value > 0 else (here, high)
        step = -value / slope if slope > 0 else math.copysign(math.inf, -value)
        if abs(step) <= ACCURACY:
            return here + step
        goal = here + step
        if not low <= goal <= high or not math.isfinite(goal):
            width = math.copysign(max(abs(here), LEAST_WIDTH), -value)
            goal = 0.5 * (low + high) if math.isfinite(high - low) else here + width
        here = goal
    return here


def _smoothed(values: FloatArray, sample_time: float) -> FloatArray:
    """Lead values through their jumps: three running means in a row, together as long as `SMOOTHING_TIME`.

    It looks as far ahead as back; beyond the ends the values go on as they are there.
    """
    half = max(1, round(SMOOTHING_TIME / sample_time / 6))
    window = np.ones(2 * half + 1) / (2 * half + 1)
    for _ in range(3):
        values = np.convolve(np.pad(values, half, mode="edge"), window, mode="valid")
    return values
