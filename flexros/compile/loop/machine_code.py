"""The closed loop as one module of machine code."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.compiled_function import bind_packed, packed_entry
from flexros.compile.loop.driver import ADVANCE, JOB_FIELDS, MEASURE, RUN, LoopDriver, LoopSymbols
from flexros.compile.loop.runge_kutta import whole_step
from flexros.compile.module_builder import ModuleBuilder, check_lanes

if TYPE_CHECKING:
    from collections.abc import Callable

    import casadi as ca

    from flexros.arrays import FloatArray
    from flexros.compile.command_delay import CommandDelay, MotorDelays
    from flexros.compile.loop.arrays import LoopJob
    from flexros.compile.loop.functions import LoopFunctions, LoopSizes


class MachineCodeLoop:
    """Engine of a closed loop in machine code; runs release the GIL, half samples hold it."""

    def __init__(
        self, functions: LoopFunctions, sizes: LoopSizes, delay: CommandDelay | MotorDelays, substeps: int, lanes: int
    ) -> None:
        """Compile the loop.

        Args:
            functions: Plant and controller.
            sizes: Their sizes.
            delay: Parts of a sample and remembered commands.
            substeps: Runge-Kutta steps per part.
            lanes: Parallel simulations: 1, 2, 4, 8, 16.
        """
        check_lanes(lanes)
        builder = ModuleBuilder()
        driver = LoopDriver(add_functions(builder, functions, lanes), sizes, delay, substeps, lanes)
        builder.add_text(driver.text())
        builder.add_text(packed_entry(MEASURE, 5))
        builder.add_text(packed_entry(ADVANCE, 5))
        code = builder.build()
        self._code = code
        self._run = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(code.address(RUN))
        self._measure = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)(code.address(f"{MEASURE}.packed"))
        self._advance = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)(code.address(f"{ADVANCE}.packed"))

    def run(self, job: LoopJob) -> int:
        """Run a job in place; return the number of samples until every lane has diverged, else all."""
        values = np.array([_entry(job, name) for name in JOB_FIELDS], dtype=np.int64)
        return int(self._run(values.ctypes.data))

    def measure(
        self, plant: FloatArray, noise: FloatArray, parameters: FloatArray, measured: FloatArray, tool_pose: FloatArray
    ) -> Callable[[], None]:
        """Prepare the measurement of all sensors and of the tool pose."""
        return self._bind(self._measure, plant, noise, parameters, measured, tool_pose)

    def advance(
        self, plant: FloatArray, line: FloatArray, command: FloatArray, disturbance: FloatArray, parameters: FloatArray
    ) -> Callable[[], None]:
        """Prepare the step from one sample to the next."""
        return self._bind(self._advance, plant, line, command, disturbance, parameters)

    def _bind(self, call: Callable[[int], object], *arrays: FloatArray) -> Callable[[], None]:
        bound = bind_packed(call, arrays)
        bound.owners += (self,)
        return bound


def add_functions(builder: ModuleBuilder, functions: LoopFunctions, lanes: int) -> LoopSymbols:
    """Add the functions of a loop to a module, and return their symbols."""

    def add(name: str, function: ca.Function) -> str:
        return builder.add_function(function, name=name, lanes=lanes)

    step = whole_step(functions)
    sensor, exact_update = functions.sensor, functions.exact_update
    return LoopSymbols(
        derivative=None if step is not None else add("derivative", functions.derivative),
        merged_step=None if step is None else add("merged_step", step),
        encoder=add("encoder", functions.encoder),
        tool_pose=add("tool_pose", functions.tool_pose),
        controller=add("controller", functions.controller),
        sensor=None if sensor is None else add("sensor", sensor),
        exact_update=None if exact_update is None else add("exact_update", exact_update),
        before_step=None if functions.before_step is None else add("before_step", functions.before_step),
        after_step=None if functions.after_step is None else add("after_step", functions.after_step),
        further=None if functions.further is None else add("further", functions.further),
    )


def _entry(job: LoopJob, name: str) -> int:
    """Return the 64 bits of one entry of the job."""
    if name == "samples":
        return job.samples
    if name.endswith("_stride"):
        signal: FloatArray = getattr(job, name.removesuffix("_stride"))
        return int(signal[0].size) if signal.shape[0] > 1 else 0
    if name.endswith("_shared"):
        signal = getattr(job, name.removesuffix("_shared"))
        return int(signal.shape[-1] == 1)
    array: FloatArray | None = getattr(job, name)
    return 0 if array is None else int(array.ctypes.data)
