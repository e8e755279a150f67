"""Compensation of effects at the motors: friction, ripple, bias, gain and lag."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.effects.kinds.bristle_friction import AbstractBristleFriction
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.motor_law import AbstractMotorLaw, AbstractMotorTorque, MotorState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.feedforward.motion import Motion
    from flexros.robot import Robot

SMOOTHING = 1e-3
"""Speed at which the smoothed sign of dry friction reaches tanh(1), relative to the largest of the motion (chosen)."""

GAIN, LAG = 1, 2
"""Ranks of laws between command and motor that can be inverted, see `AbstractCommandLaw.rank`."""


def with_motor_laws(motion: Motion, robot: Robot, laws: Sequence[PlacedLaw], sample_time: float) -> Motion:
    """Change the torques such that the effects at the motors cancel the change.

    The effects are inverted from the motor back to the command: friction and other torques at the motor, then lag, then
    gain. Effects of other kinds are skipped.

    Args:
        motion: The whole motion, with the torques that the motors must produce.
        robot: The robot.
        laws: Laws on it.
        sample_time: Distance of the samples [s].

    Returns:
        The motion with the torques to command.
    """
    for number, name in enumerate(robot.joint_names):
        motor = _Motor(motion, robot, number, sample_time)
        effects = [law.effect for law in laws if law.location == name]
        dry = [effect for effect in effects if isinstance(effect, AbstractDryFriction)]
        torque = motor.dry_friction(dry) if dry else np.zeros(len(motion))
        for bristle in effects:
            if isinstance(bristle, AbstractBristleFriction):
                torque += motor.bristle_friction(bristle)
        motion = _added(motion, number, torque) if torque.any() else motion
        smooth = [effect for effect in effects if isinstance(effect, AbstractMotorTorque)]
        if smooth:
            motion = _scaled(motion, number, *motor.smooth_torques(smooth))
        chain = [effect for effect in effects if isinstance(effect, AbstractCommandLaw)]
        for command in sorted(chain, key=lambda effect: -effect.rank):
            if command.rank == LAG:
                motion = _ahead_of_lag(motion, number, command.parameter_values[command.size], sample_time)
            elif command.rank == GAIN:
                motion = _scaled(motion, number, *_gain(command))
    return motion


class _Motor:
    """A motor along its planned motion: evaluates laws that depend on its state.

    A diagnosis evaluates the same laws in a measured motion, for many sets of their parameters, but without own states:
    `gap.residuals.torque_errors`.
    """

    def __init__(self, motion: Motion, robot: Robot, number: int, sample_time: float) -> None:
        self._sample_time = sample_time
        q, v, u, load = self._symbols = [ca.SX.sym(name) for name in ("q", "v", "u", "load")]
        turns, name = float(robot.rotor_turns[number]), robot.joint_names[number]
        friction, inertia = (robot.parameters[f"{name}.{value}"].value for value in ("viscous_friction", "inertia"))
        self._state = MotorState(q, turns * q, v, u, viscous_friction=friction, load=load)
        self._rows = [array[:, number] for array in (motion.motor_position, motion.motor_velocity, motion.torque)]
        transmitted = motion.load[:, number] - friction * self._rows[1]
        if number in robot.stiff_motors:
            transmitted = transmitted - inertia * _rate(self._rows[1], sample_time)
        self._rows.append(transmitted)

    @property
    def direction(self) -> FloatArray:
        """Smoothed sign of the speed: otherwise a reference at rest would switch friction by round-off."""
        speed = self._rows[1]
        largest = float(np.abs(speed).max())
        return np.tanh(speed / (SMOOTHING * largest)) if largest > 0 else np.zeros_like(speed)

    def dry_friction(self, effects: Sequence[AbstractDryFriction]) -> FloatArray:
        """Compute the torque against dry friction: sum of the levels times the smoothed sign, shape (n,)."""
        forward, backward = np.zeros(len(self._rows[0])), np.zeros(len(self._rows[0]))
        for effect in effects:
            state = self._with_own(effect)
            levels = effect.levels(state, effect.parameter_values)
            ahead, back = self._values(effect, state, [levels.forward, levels.backward])
            forward, backward = forward + ahead, backward + back
        direction = self.direction
        return np.where(direction > 0, np.maximum(forward, 0), np.maximum(backward, 0)) * direction

    def bristle_friction(self, effect: AbstractBristleFriction) -> FloatArray:
        """Compute the torque of a bristle, shape (n,): dz = dq - s0 z |dq| / g, solved exactly over each sample."""
        bristle = effect.bristle(self._symbols[1], effect.parameter_values)
        numbers = [ca.SX(bristle.level), ca.SX(bristle.stiffness), ca.SX(bristle.damping)]
        level, stiffness, damping = self._values(effect, self._state, numbers)
        z, moved, reach = np.zeros(len(level)), np.diff(self._rows[0]), level / stiffness
        decay = np.exp(-np.abs(moved) / reach[1:])
        end = np.sign(moved) * reach[1:] * (1 - decay)
        for k in range(len(moved)):
            z[k + 1] = decay[k] * z[k] + end[k]
        return stiffness * z + damping * _rate(z, self._sample_time)

    def smooth_torques(self, effects: Sequence[AbstractMotorTorque]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Compute offset and slope of u + added(u), linear in u, and the slope's time derivative, each shape (n,)."""
        q, v, u, _ = self._symbols
        total = [np.zeros(len(self._rows[0])), np.ones(len(self._rows[0])), np.zeros(len(self._rows[0]))]
        for effect in effects:
            state = self._with_own(effect)
            added = ca.SX(effect.added(state, effect.parameter_values))
            slope = ca.jacobian(added, u)
            parts = self._values(effect, state, [ca.substitute(added, u, 0), slope, ca.jtimes(slope, q, v)])
            total = [sum_ + part for sum_, part in zip(total, parts)]
        return total[0], total[1], total[2]

    def _with_own(self, effect: AbstractMotorLaw) -> MotorState:
        return replace(self._state, own=ca.SX.sym("own", effect.n_states))

    def _values(self, effect: AbstractMotorLaw, state: MotorState, outputs: list[ca.SX]) -> list[FloatArray]:
        """Evaluate functions of the motor's state for all samples; each array has the shape (n,)."""
        n, size = len(self._rows[0]), state.own.numel()
        function = ca.Function("law", [*self._symbols, state.own], [ca.densify(ca.SX(output)) for output in outputs])
        own = self._integrated(effect, state) if size else np.zeros((n, 0))
        values = function.call([*(ca.DM(row[np.newaxis]) for row in self._rows), ca.DM(own.T)])
        return [np.broadcast_to(np.array(value, dtype=float).ravel(), (n,)) for value in values]

    def _integrated(self, effect: AbstractMotorLaw, state: MotorState) -> FloatArray:
        """Integrate the own states of a law from zero by Euler steps, shape (n, n_states); they are slow."""
        rates = ca.densify(effect.rates(state, effect.parameter_values))
        rate = ca.Function("rate", [*self._symbols, state.own], [rates])
        own = np.zeros((len(self._rows[0]), effect.n_states))
        for k in range(1, len(own)):
            slope = np.array(rate(*(row[k - 1] for row in self._rows), own[k - 1])).ravel()
            own[k] = own[k - 1]
            own[k, : len(slope)] += self._sample_time * slope
        return own


def _added(motion: Motion, motor: int, torque: FloatArray) -> Motion:
    """Add a torque [Nm or N], shape (n,), at one motor."""
    friction = np.zeros_like(motion.torque)
    friction[:, motor] = torque
    return motion.with_friction(friction)


def _scaled(
    motion: Motion,
    motor: int,
    offset: FloatArray | float,
    slope: FloatArray | float,
    slope_rate: FloatArray | float = 0.0,
) -> Motion:
    """Solve offset + slope u = torque for the command u of a motor; `slope_rate` is the slope's time derivative."""
    torque, load, momentum = (array.copy() for array in (motion.torque, motion.load, motion.momentum))
    torque[:, motor] = (torque[:, motor] - offset) / slope
    load[:, motor] = (load[:, motor] - offset) / slope + momentum[:, motor] * slope_rate / np.square(slope)
    momentum[:, motor] /= slope
    return replace(motion, torque=torque, load=load, momentum=momentum)


def _gain(effect: AbstractCommandLaw) -> tuple[float, float]:
    """Return offset and slope of a memoryless law that is linear in the torque."""
    torque = ca.SX.sym("torque")
    passed = effect.passed(torque, ca.SX.zeros(effect.n_states), effect.parameter_values)
    law = ca.Function("passed", [torque], [passed])
    offset = float(law(0.0))
    return offset, float(law(1.0)) - offset


def _ahead_of_lag(motion: Motion, motor: int, time_constant: float, sample_time: float) -> Motion:
    """Invert a first-order lag with time constant t: u = T + t dT/dt for the required torque T.

    The second term is a time derivative, so t T is added to the momentum: the mean of its derivative over the time in
    which the command is held follows from both ends.
    """
    torque, momentum = motion.torque.copy(), motion.momentum.copy()
    momentum[:, motor] += time_constant * torque[:, motor]
    torque[:, motor] += time_constant * _rate(torque[:, motor], sample_time)
    return replace(motion, torque=torque, momentum=momentum)


def _rate(values: FloatArray, sample_time: float) -> FloatArray:
    """Compute the time derivative by central differences, shape (n,); zero for a single sample."""
    return np.asarray(np.gradient(values, sample_time)) if len(values) > 1 else np.zeros_like(values)
