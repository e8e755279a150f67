"""The closed loop on the CasADi virtual machine: no compiler, and a cross-check of the machine code to 1e-12."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.loop.functions import WRENCH_SIZE
from flexros.compile.loop.runge_kutta import runge_kutta_step, step_weights, whole_step
from flexros.compile.module_builder import check_lanes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.compile.command_delay import CommandDelay, MotorDelays
    from flexros.compile.loop.arrays import LoopJob
    from flexros.compile.loop.functions import LoopFunctions, LoopSizes

_SLICE = 200  # samples per call of the virtual machine


class VirtualMachineLoop:
    """Engine of a closed loop that evaluates the functions with CasADi, lane after lane."""

    def __init__(
        self, functions: LoopFunctions, sizes: LoopSizes, delay: CommandDelay | MotorDelays, substeps: int, lanes: int
    ) -> None:
        """Build the functions of one sample.

        Args:
            functions: Plant and controller.
            sizes: Their sizes.
            delay: Parts of a sample and remembered commands.
            substeps: Runge-Kutta steps per part.
            lanes: Parallel simulations: 1, 2, 4, 8, 16.
        """
        check_lanes(lanes)
        self._sizes = sizes
        self._line_length = delay.line_length
        self._measure = _measure_function(functions, sizes)
        self._advance = _advance_function(functions, sizes, delay, substeps)
        self._sample = _sample_function(functions, sizes, self._measure, self._advance)
        self._samples = lru_cache(maxsize=2)(lambda n: self._sample.mapaccum("samples", n))

    def run(self, job: LoopJob) -> int:
        """Run a job in place; return the number of samples until every lane has diverged, else all."""
        for lane in range(job.lanes):
            self._run_lane(job, lane)
        return int(job.diverged.max()) if (job.diverged >= 0).all() else job.samples

    def measure(
        self, plant: FloatArray, noise: FloatArray, parameters: FloatArray, measured: FloatArray, tool_pose: FloatArray
    ) -> Callable[[], None]:
        """Prepare the measurement of all sensors and of the tool pose."""

        def call() -> None:
            for lane in range(plant.shape[1]):
                y, pose = self._measure(plant[:, lane], noise[:, lane], parameters[:, lane])
                measured[:, lane], tool_pose[:, lane] = _matrix(y)[:, 0], _matrix(pose)[:, 0]

        return call

    def advance(
        self, plant: FloatArray, line: FloatArray, command: FloatArray, disturbance: FloatArray, parameters: FloatArray
    ) -> Callable[[], None]:
        """Prepare the step from one sample to the next."""

        def call() -> None:
            for lane in range(plant.shape[1]):
                x, past = self._advance(
                    plant[:, lane],
                    line[:, :, lane].ravel(),
                    command[:, lane],
                    disturbance[:, lane],
                    parameters[:, lane],
                )
                plant[:, lane] = _matrix(x)[:, 0]
                line[:, :, lane] = _matrix(past).reshape(line.shape[:2])

        return call

    def _run_lane(self, job: LoopJob, lane: int) -> None:
        """Run one lane up to its end or to the first state that is not finite."""
        sizes = self._sizes
        state = np.concatenate([job.plant[:, lane], job.controller[:, lane], job.line[:, :, lane].ravel()])
        constants = np.concatenate([job.parameters[:, lane], job.gains[:, lane]])
        for start in range(0, job.samples, _SLICE):
            stop = min(start + _SLICE, job.samples)
            signals = [_rows(s, start, stop, lane) for s in (job.reference, job.noise, job.disturbance)]
            held = np.repeat(constants[:, np.newaxis], stop - start, axis=1)
            states, y, u, pose = (_matrix(a) for a in self._samples(stop - start)(state, *signals, held))
            before = np.column_stack([state, states[:, :-1]])
            finite = np.isfinite(states[: sizes.state]).all(axis=0)
            done = stop - start if finite.all() else int(np.argmin(finite)) + 1
            outputs = ((job.measured, y), (job.command, u), (job.tool_pose, pose), (job.states, before[: sizes.state]))
            for target, numbers in outputs:
                if target is not None:
                    target[start : start + done, :, lane] = numbers[:, :done].T
            state = states[:, done - 1]
            if not finite.all():
                job.diverged[lane] = start + done
                break
        x, c, line = np.split(state, [sizes.state, sizes.state + sizes.controller])
        job.plant[:, lane], job.controller[:, lane] = x, c
        job.line[:, :, lane] = line.reshape(job.line.shape[:2])


def _matrix(value: ca.DM) -> FloatArray:
    return np.asarray(value.full(), dtype=np.float64)


def _rows(signal: FloatArray, start: int, stop: int, lane: int) -> FloatArray:
    """Return a signal of one lane as (width, samples)."""
    numbers: FloatArray = signal[:, :, lane if signal.shape[-1] > 1 else 0]
    columns: FloatArray = np.repeat(numbers, stop - start, axis=0) if numbers.shape[0] == 1 else numbers[start:stop]
    result: FloatArray = columns.T
    return result


def _symbols(*sizes: int) -> list[ca.MX]:
    return [ca.MX.sym(f"s{k}", size) for k, size in enumerate(sizes)]


def _leading(function: ca.Function, x: ca.MX) -> ca.MX:
    """Return the leading part of the state that a function takes."""
    return x[: function.numel_in(0)]


def _measure_function(functions: LoopFunctions, sizes: LoopSizes) -> ca.Function:
    x, noise, p = _symbols(sizes.state, sizes.measured, sizes.parameters)
    y = functions.encoder(_leading(functions.encoder, x)) + noise[: sizes.motors]
    if functions.sensor is not None:
        y = functions.sensor(y, x, p)
    if functions.further is not None:
        y = ca.vertcat(y, functions.further(x, p) + noise[sizes.motors :])
    return ca.Function("measure", [x, noise, p], [y, functions.tool_pose(_leading(functions.tool_pose, x), p)])


def _step_function(functions: LoopFunctions, sizes: LoopSizes, h: float) -> ca.Function:
    """Build one Runge-Kutta step with the updates before and after it: (x, u, w, p) -> x."""
    x, u, w, p = _symbols(sizes.state, sizes.motors, WRENCH_SIZE, sizes.parameters)

    def updated(function: ca.Function | None, state: ca.MX, duration: float) -> ca.MX:
        return state if function is None else function(state, u, w, p, duration)

    step = whole_step(functions) or runge_kutta_step(functions, ca.MX)
    begin = updated(functions.exact_update, updated(functions.before_step, x, h), 0.5 * h)
    end = updated(functions.exact_update, step(begin, u, w, p, ca.DM(step_weights(h))), 0.5 * h)
    return ca.Function("step", [x, u, w, p], [updated(functions.after_step, end, h)])


def _advance_function(
    functions: LoopFunctions, sizes: LoopSizes, delay: CommandDelay | MotorDelays, substeps: int
) -> ca.Function:
    m = sizes.motors
    x, line, u, d, p = arguments = _symbols(sizes.state, m * delay.line_length, m, sizes.disturbance, sizes.parameters)
    commands = ca.vertcat(u, line)
    for piece in delay.torque_pieces(m):
        torque = commands[[age * m + motor for motor, age in enumerate(piece.ages)]] + d[:m]
        step = _step_function(functions, sizes, piece.duration / substeps)
        for _ in range(substeps):
            x = step(x, torque, d[m:], p)
    return ca.Function(
        "advance", arguments, [x, ca.vertsplit(commands, [0, m * delay.line_length, commands.numel()])[0]]
    )


def _sample_function(
    functions: LoopFunctions, sizes: LoopSizes, measure: ca.Function, advance: ca.Function
) -> ca.Function:
    """Build one sample: (state, r, noise, d, [p, g]) -> (next state, y, u, pose), state = [x, c, line]."""
    state_sizes: Sequence[int] = (sizes.state, sizes.controller, advance.numel_in(1))
    state = ca.MX.sym("state", sum(state_sizes))
    r, noise, d = _symbols(sizes.reference, sizes.measured, sizes.disturbance)
    constants = ca.MX.sym("constants", sizes.parameters + sizes.gains)
    x, c, line = ca.vertsplit(state, [0, *np.cumsum(state_sizes).tolist()])
    p, g = ca.vertsplit(constants, [0, sizes.parameters, constants.numel()])
    y, pose = measure(x, noise, p)
    u, c = functions.controller(c, r, y, g)
    x, line = advance(x, line, u, d, p)
    return ca.Function("sample", [state, r, noise, d, constants], [ca.vertcat(x, c, line), y, u, pose])
