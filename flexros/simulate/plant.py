"""The simulated robot, stepped sample by sample, as in the plant node."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.loop.arrays import LoopState
from flexros.compile.loop.kernel import compile_loop
from flexros.errors import RunError
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel
from flexros.simulate.sample_blocks import Zeros
from flexros.simulate.sensor_timing import SensorMemory, SensorTiming
from flexros.simulate.servo_lead import servo_leads
from flexros.simulate.signals import plant_signals

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.robot import Robot
    from flexros.simulate.disturbance import AbstractDisturbance


class Plant:
    """Robot, sensors and disturbances in time; equal to the run of the whole loop to the last bit.

    At sample k, `measure` and `tool_pose` return the measurements at t_k = k T, and `advance` integrates to t_(k+1)
    under the command of t_k, which acts from t_k + delay on. The arguments determine all results. The commands of a
    robot that is commanded by positions are those of its servos [rad or m].

    Args:
        robot: The robot, with its delay and sensor noise.
        sample_time: Time T between two samples [s].
        state: State at t_0, shape (2 nq,).
        seed: Seed of noise and random disturbances.
        noise: Whether the sensors have the noise of the robot file.
        disturbances: Torques and forces at motors and tool.
        substeps: Integration steps in a sample.
        torque: Command that acts until the first one arrives through the delay [Nm or N], shape (M,); default: zero.
        laws: Laws of effects.

    Raises:
        InputError: Unknown location or too high frequency of a disturbance, or an argument out of range.
    """

    def __init__(
        self,
        robot: Robot,
        sample_time: float,
        state: FloatArray,
        *,
        seed: int = 0,
        noise: bool = False,
        disturbances: Sequence[AbstractDisturbance] = (),
        substeps: int = 1,
        torque: FloatArray | None = None,
        laws: Sequence[PlacedLaw] = (),
    ) -> None:
        self.robot = robot
        self.sample_time = sample_time
        self.sample = 0
        self._signals = plant_signals(robot, sample_time, seed, noise=noise, disturbances=disturbances)
        model = PlantModel(robot, laws, sensors=robot.further_sensors)
        self.sensor_timing = SensorTiming.of(robot.further_sensors, sample_time)
        kernel = compile_loop(
            model.functions(feed_through(robot.n_motors, self.sensor_timing.size)),
            sample_time=sample_time,
            substeps=substeps,
            delay=model.delay,
        )
        start = delayed_start(
            model.start(state, torque),
            np.zeros(0),
            np.zeros(robot.n_motors) if torque is None else torque,
            kernel.line_length,
        )
        self._step = kernel.stepper(start)
        self._measured = -1
        leads = servo_leads(robot, {}) if robot.commands == "position" else np.zeros(robot.n_motors)
        self._leads = leads if leads.any() else None
        self._before: FloatArray | None = None
        self._memory = SensorMemory(self.sensor_timing)
        self._held = np.zeros(self.sensor_timing.size)

    @property
    def time(self) -> float:
        """Time of the present sample [s]."""
        return self.sample * self.sample_time

    @property
    def state(self) -> FloatArray:
        """Copy of the robot's state x at the present sample, shape (2 nq,)."""
        state: FloatArray = self._step.plant[: 2 * self.robot.n_coordinates].copy()
        return state

    def measure(self) -> FloatArray:
        """Return the encoders' motor positions at the present sample, with noise [rad or m], shape (M,)."""
        self._sense()
        encoder: FloatArray = self._step.encoder.copy()
        return encoder

    def further(self) -> FloatArray:
        """Return what the further sensors show at the present sample, with errors, delay and hold, shape (n_further,).

        The channels are those of `robot.further_sensors`, in order.
        """
        self._sense()
        return self._held.copy()

    def tool_pose(self) -> FloatArray:
        """Return the tracker's tool pose at the present sample: noisy position [m] and quaternion xyzw, shape (7,)."""
        self._sense()
        pose: FloatArray = self._step.tool_pose.copy()
        if not isinstance(self._signals.tool_noise, Zeros):
            pose[:3] += self._signals.tool_noise.row(self.sample)
        return pose

    def advance(self, command: FloatArray | Sequence[float], rate: FloatArray | None = None) -> None:
        """Integrate to the next sample.

        Args:
            command: Torque command of the present sample [Nm or N], or position of the servos [rad or m], shape (M,).
            rate: Rate of commanded positions, which servos with feedforward follow [rad/s or m/s], shape (M,); default:
                by the command before.

        Raises:
            RunError: The command has the wrong size or is not finite (the state is unchanged), or the new state is not
                finite.
        """
        if len(command) != self.robot.n_motors:
            raise RunError(
                f"{self._source()}: the torque command has {len(command)} values, needed are {self.robot.n_motors}"
            )
        step = self._step
        step.command[:] = command
        if self._leads is not None:
            given = step.command.copy()
            if rate is None and self._before is not None:
                rate = (given - self._before) / self.sample_time
            self._before = given
            step.command[:] += self._leads * (0.0 if rate is None else rate)
        if not math.isfinite(sum(step.command.tolist())):
            motor = int(np.argmin(np.isfinite(step.command)))
            wrong = f"the torque command of motor_{motor + 1} is {step.command[motor]}"
            raise RunError(f"{self._source()}: {wrong}, needed is a finite number")
        if not isinstance(self._signals.disturbance, Zeros):
            step.disturbance[:] = self._signals.disturbance.row(self.sample)
        step.advance()
        self.sample += 1
        if not math.isfinite(sum(step.plant.tolist())):
            raise RunError(diverged_text(self.robot.name, self.sample, self.sample_time))

    def _sense(self) -> None:
        if self._measured != self.sample:
            if not isinstance(self._signals.measurement_errors, Zeros):
                self._step.noise[:] = self._signals.measurement_errors.row(self.sample)
            self._step.measure()
            self._measured = self.sample
            if self.sensor_timing.size:
                self._held = self._memory.add(self.sample, self._step.further)

    def _source(self) -> str:
        return f"robot {self.robot.name} at sample {self.sample} (t = {self.time:.4f} s)"


def delayed_start(plant: FloatArray, controller: FloatArray, torque: FloatArray, line_length: int) -> LoopState:
    """Return the initial state of a loop at rest, with its delay line filled with a constant torque.

    Args:
        plant: State of the plant, shape (n_states,) or (n_states, lanes).
        controller: State of the controller, shape (n_c,).
        torque: Torque that acts until the first command arrives [Nm or N], shape (M,) or (M, lanes).
        line_length: Number of past commands in the delay line.
    """
    return LoopState(plant, controller, np.repeat(np.asarray(torque, dtype=float)[np.newaxis], line_length, axis=0))


def diverged_text(name: str, sample: int, sample_time: float) -> str:
    """Return the message for a diverged simulation."""
    return (
        f"robot {name}: the simulated state is not finite at sample {sample} (t = {sample * sample_time:.4f} s): the "
        "loop is unstable or the integration step too long; lower the gains or raise substeps"
    )
