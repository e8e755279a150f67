"""Runs of many models and seeds in SIMD lanes: one compilation per structure of controller."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import casadi as ca
import numpy as np

from flexros.benchmark.disturbances import DURATION, disturbance_rows
from flexros.benchmark.models import PARAMETERS
from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import LoopKernel, compile_loop
from flexros.control.context import LoopContext
from flexros.random_streams import Stream
from flexros.simulate.plant_model import PlantModel
from flexros.simulate.signals import white_noise

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.compile.loop.functions import LoopFunctions
    from flexros.control.base import AbstractControlLaw
    from flexros.robot import Robot

LANES = 8
"""Runs side by side in one thread [1]."""

NOISE = 3e-4
"""Standard deviation of the white noise of the motor encoder [rad], chosen."""

QUIET = 4.0
"""Time after the disturbances in which a limit cycle is looked for [s], chosen."""

Figure = TypeVar("Figure")


class RegulatorSimulation:
    """Runs of the regulator problem, from rest at zero, with the disturbances of the benchmark.

    Args:
        robot: The robot of the benchmark, with its delay.
        quiet: Time after the disturbances [s].
        loop_gain: Factor on the measurements, and with it on the loop gain of a linear law [1].
    """

    def __init__(self, robot: Robot, *, quiet: float = 0.0, loop_gain: float = 1.0) -> None:
        self.robot = robot
        self.context = LoopContext(robot, robot.sample_time)
        self.n_samples = round((DURATION + quiet) / robot.sample_time) + 1
        self._loop_gain = loop_gain
        self._kernels: dict[str, LoopKernel] = {}
        self._noise: dict[tuple[float, int], FloatArray] = {}

    @cached_property
    def _plant(self) -> PlantModel:
        return PlantModel(self.robot, (), PARAMETERS, sensors=self.robot.further_sensors)

    @cached_property
    def _disturbance(self) -> FloatArray:
        return disturbance_rows(self.n_samples, self.robot.sample_time)

    def kernel(self, law: AbstractControlLaw) -> LoopKernel:
        """Return the compiled loop with a law; laws of one structure share it."""
        update = law.function(self.context)
        if self._loop_gain != 1.0:
            c, r, y, g = update.sx_in()
            update = ca.Function("update", [c, r, y, g], list(update(c, r, self._loop_gain * y, g)))
        key = update.serialize()
        if key not in self._kernels:
            functions = self._plant.functions(update)
            self._kernels[key] = compile_loop(
                _with_deflection_only(functions, self.robot),
                sample_time=self.robot.sample_time,
                delay=self._plant.delay,
                lanes=LANES,
            )
        return self._kernels[key]

    def run(
        self,
        law: AbstractControlLaw,
        values: FloatArray,
        figure: Callable[[int, FloatArray, FloatArray], Figure],
        *,
        noise: float = 0.0,
        seeds: Sequence[int] = (1,),
        threads: int | None = None,
    ) -> list[list[Figure]]:
        """Run a law on all models with all seeds.

        Args:
            law: The control law.
            values: Values of `PARAMETERS` of the models (SI), shape (n_models, n_parameters).
            figure: Result of a run from the number of its model, tool deflection [mm] and command [Nm], shape (n,).
            noise: Standard deviation of the white measurement noise [rad].
            seeds: Seeds of the noise; without noise only the first is run.
            threads: Number of threads; default: one per processor.

        Returns:
            The results, by seed and within it by model.
        """
        kernel = self.kernel(law)
        gains = law.gains(self.context)
        chosen = tuple(seeds) if noise else tuple(seeds)[:1]
        runs = [(seed, model) for seed in chosen for model in range(len(values))]
        groups = [runs[first : first + LANES] for first in range(0, len(runs), LANES)]
        signals = {seed: self._noise_rows(noise, seed) for seed in chosen}

        def one(group: list[tuple[int, int]]) -> list[Figure]:
            members = [*group, *[group[-1]] * (LANES - len(group))]
            same = len({seed for seed, _ in members}) == 1
            result = kernel.run(
                kernel.initial_state(np.zeros((self._plant.n_states, LANES)), law.initial_state(self.context)),
                self.n_samples,
                LoopInputs(
                    noise=None
                    if not noise
                    else signals[members[0][0]]
                    if same
                    else np.stack([signals[seed] for seed, _ in members], axis=-1),
                    disturbance=self._disturbance,
                    parameters=np.ascontiguousarray(values[[model for _, model in members]].T),
                    gains=gains,
                ),
            )
            assert result.tool_pose is not None
            deflection = 1e3 * result.tool_pose[:, 0].T
            command = np.ascontiguousarray(result.command[:, 0].T)
            return [figure(model, deflection[lane], command[lane]) for lane, (_, model) in enumerate(group)]

        with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
            flat = [entry for part in pool.map(one, groups) for entry in part]
        return [flat[first : first + len(values)] for first in range(0, len(flat), len(values))]

    def _noise_rows(self, noise: float, seed: int) -> FloatArray:
        """Return the measurement noise of a seed, shape (n, n_measured); the same as of a run over topics.

        Noise of further sensors is changed in the proportion of that of the encoder.
        """
        if (noise, seed) not in self._noise:
            share = noise / NOISE
            further = np.array([share * sensor.noise for sensor in self.robot.further_sensors for _ in sensor.indices])
            parts = [white_noise(np.full(self.robot.n_motors, noise), seed, Stream.ENCODER)]
            if further.size:
                parts.append(white_noise(further, seed, Stream.FURTHER_SENSORS))
            self._noise[noise, seed] = np.hstack([part.rows(0, self.n_samples) for part in parts])
        return self._noise[noise, seed]


def _with_deflection_only(functions: LoopFunctions, robot: Robot) -> LoopFunctions:
    """Record the controlled component of the tool alone, one column instead of a whole pose."""
    component = "xyz".index(robot.spec.outputs[robot.controlled].pose[0])
    pose = functions.tool_pose
    x, p = pose.sx_in()
    return replace(functions, tool_pose=ca.Function("deflection", [x, p], [pose(x, p)[component]]))
