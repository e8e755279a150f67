"""Torque and speed that an identification experiment causes on the nominal model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.control.context import LoopContext
from flexros.identify.experiment.closed_loop_response import (
    ControllerResponse,
    LoopResponse,
    controller_response,
    loop_response,
)
from flexros.identify.experiment.excursion import half_way
from flexros.identify.experiment.slow_motion import ConstantSpeed, SlowSine

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.excitation.base import BlockSignals
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class PredictionAtRest:
    """Prediction about one position.

    Attributes:
        plan: The plan.
        lines: Lines of the prediction, shape (F,).
        response: Closed loop at these lines.
        offset: Lowest and highest torque without excitation [Nm or N], each of shape (M,) or (n, M).
    """

    plan: ExperimentPlan
    lines: IntArray
    response: LoopResponse
    offset: tuple[FloatArray, FloatArray]

    def torque(self, signals: BlockSignals) -> FloatArray:
        """Return the torque that the excitation of a block adds over one period or record.

        Args:
            signals: The excitation.

        Returns:
            Torque [Nm or N], shape (n_experiments, n, M).
        """
        return self._answer(self.response.torque, signals)

    def speed(self, signals: BlockSignals) -> FloatArray:
        """Return the motor speed that the excitation of a block causes over one period or record.

        Args:
            signals: The excitation.

        Returns:
            Speed [rad/s or m/s], shape (n_experiments, n, M).
        """
        return self._answer(self.response.speed, signals)

    def _answer(self, response: ComplexArray, signals: BlockSignals) -> FloatArray:
        """Return the response to the excitation, shape (n_experiments, n, M)."""
        references = np.concatenate([signals.position, signals.speed], axis=2)
        spectrum = np.fft.rfft(references, axis=1)
        answer = np.zeros((*spectrum.shape[:2], self.plan.n_motors), dtype=complex)
        answer[:, self.lines] = np.einsum("fij,efj->efi", response, spectrum[:, self.lines])
        return np.fft.irfft(answer, references.shape[1], axis=1)


@dataclass(frozen=True, eq=False)
class LoopPrediction:
    """Prediction for all positions of a plan.

    Attributes:
        plan: The plan.
        robot: The nominal robot.
        controller: Its controller, linearised.
        lines: Lines of the prediction: the excited band, a slow sine included, shape (F,).
    """

    plan: ExperimentPlan
    robot: Robot
    controller: ControllerResponse
    lines: IntArray

    @classmethod
    def of(cls, plan: ExperimentPlan, robot: Robot, law: AbstractControlLaw) -> LoopPrediction:
        """Prepare the prediction.

        Args:
            plan: The plan.
            robot: The nominal robot.
            law: The feedback controller.
        """
        lines, motion = plan.excited_lines, plan.specification.slow_motion
        if isinstance(motion, SlowSine):
            lines = np.union1d(lines, [motion.cycles])
        controller = controller_response(law, LoopContext(robot, plan.sample_time), _frequency(plan, lines))
        return cls(plan, robot, controller, lines)

    def at(self, state: FloatArray) -> PredictionAtRest:
        """Predict about a rest.

        Args:
            state: State at rest, shape (2 n_coordinates,).
        """
        frequency = _frequency(self.plan, self.lines)
        arm = state[: self.robot.n_arm]
        response = loop_response(self.robot, arm, self.controller, self.plan.sample_time, frequency)
        return PredictionAtRest(self.plan, self.lines, response, self._offset(state, response.torque))

    def _offset(self, state: FloatArray, response: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Return the torque at rest and at the slow motion: gravity load, friction, and what a sine accelerates."""
        robot, plan, motion = self.robot, self.plan, self.plan.specification.slow_motion
        holding = robot.holding_torque(state)
        if isinstance(motion, SlowSine):
            speed = motion.speeds(plan.n_motors)
            line = int(np.searchsorted(self.lines, motion.cycles))
            rate = 2.0 * np.pi * float(_frequency(plan, self.lines)[line])
            size = response[line] @ np.concatenate([speed / (1j * rate), speed])
            angle = 2.0 * np.pi * motion.cycles * np.arange(plan.period_samples) / plan.period_samples
            torque = holding + (size * np.exp(1j * angle)[:, None]).real
            return torque, torque
        if isinstance(motion, ConstantSpeed):
            friction = self._at_speed(state, motion.speeds(plan.n_motors)) - holding
            ends = [self._moved(state, sign * half_way(plan)) for sign in (-1.0, 0.0, 1.0)]
            sides = np.array([end + sign * friction for end in ends for sign in (-1.0, 1.0)])
            return np.min(sides, axis=0), np.max(sides, axis=0)
        return holding, holding

    def _moved(self, state: FloatArray, way: FloatArray) -> FloatArray:
        """Return the torque that holds the robot with the gears moved [Nm or N], shape (M,)."""
        arm = state[: self.robot.n_arm].copy()
        arm[list(self.robot.gear_rows)] += way
        return self.robot.holding_torque(self.robot.equilibrium(arm))

    def _at_speed(self, state: FloatArray, speed: FloatArray) -> FloatArray:
        """Return the torque at a constant speed of all gears and motors, springs and arm as at rest, shape (M,)."""
        robot, model = self.robot, self.robot.model
        n = robot.n_coordinates
        velocity = np.zeros(n)
        velocity[list(robot.gear_rows)] = speed
        velocity[robot.n_arm :] = speed[list(robot.flexible_motors)]
        holding = robot.holding_torque(state)
        force = np.asarray(model.force(state[:n], velocity, holding, np.zeros(6), model.parameter_values)).ravel()
        friction = np.zeros(robot.n_motors)
        friction[list(robot.flexible_motors)] = -force[robot.n_arm :]
        stiff = list(robot.stiff_motors)
        friction[stiff] = -force[[robot.gear_rows[motor] for motor in stiff]]
        return holding + friction


def _frequency(plan: ExperimentPlan, lines: IntArray) -> FloatArray:
    """Return the frequencies of lines [Hz], shape (F,)."""
    return np.asarray(lines / (plan.period_samples * plan.sample_time), dtype=float)
