"""The closed loop as one module of machine code."""

from __future__ import annotations

import ctypes
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.compiled_function import bind_packed, packed_entry
from flexros.compile.loop_driver import ADVANCE, JOB_FIELDS, MEASURE, RUN, LoopDriver, LoopSymbols
from flexros.compile.module_builder import ModuleBuilder, check_lanes

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.compile.command_delay import CommandDelay
    from flexros.compile.loop_arrays import LoopJob
    from flexros.compile.loop_functions import LoopFunctions, LoopSizes


class MachineCodeLoop:
    """Engine of a closed loop in machine code; runs release the GIL, half samples hold it."""

    def __init__(
        self, functions: LoopFunctions, sizes: LoopSizes, delay: CommandDelay, substeps: int, lanes: int
    ) -> None:
        """Compile the loop.

        Args:
            functions: Plant and controller.
            sizes: Their sizes.
            delay: Parts of a sample and remembered commands.
            substeps: Runge-Kutta steps per part.
            lanes: Simulations side by side: 1, 2, 4, 8, 16.
        """
        check_lanes(lanes)
        builder = ModuleBuilder()
        symbols = {
            field.name: None
            if (function := getattr(functions, field.name)) is None
            else builder.add_function(function, name=field.name, lanes=lanes)
            for field in fields(functions)
        }
        builder.add_text(LoopDriver(LoopSymbols(**symbols), sizes, delay, substeps, lanes).text())
        builder.add_text(packed_entry(MEASURE, 5))
        builder.add_text(packed_entry(ADVANCE, 5))
        code = builder.build()
        self._code = code
        self._run = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(code.address(RUN))
        self._measure = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)(code.address(f"{MEASURE}.packed"))
        self._advance = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)(code.address(f"{ADVANCE}.packed"))

    def run(self, job: LoopJob) -> int:
        """Run all samples of a job in place; return how many were done before every lane had diverged."""
        values = np.array([_entry(job, name) for name in JOB_FIELDS], dtype=np.int64)
        return int(self._run(values.ctypes.data))

    def measure(
        self, plant: FloatArray, noise: FloatArray, parameters: FloatArray, encoder: FloatArray, tool_pose: FloatArray
    ) -> Callable[[], None]:
        """Prepare the reading of encoders and tool pose."""
        return self._bind(self._measure, plant, noise, parameters, encoder, tool_pose)

    def advance(
        self, plant: FloatArray, line: FloatArray, command: FloatArray, disturbance: FloatArray, parameters: FloatArray
    ) -> Callable[[], None]:
        """Prepare the step from one sample to the next."""
        return self._bind(self._advance, plant, line, command, disturbance, parameters)

    def _bind(self, call: Callable[[int], object], *arrays: FloatArray) -> Callable[[], None]:
        bound = bind_packed(call, arrays)
        bound.owners += (self,)
        return bound


def _entry(job: LoopJob, name: str) -> int:
    """Return the 64 bits of one entry of the job."""
    if name == "samples":
        return job.samples
    if name.endswith("_stride"):
        signal: FloatArray = getattr(job, name.removesuffix("_stride"))
        return signal[0].size if signal.shape[0] > 1 else 0
    if name.endswith("_shared"):
        signal = getattr(job, name.removesuffix("_shared"))
        return int(signal.shape[-1] == 1)
    array: FloatArray | None = getattr(job, name)
    return 0 if array is None else int(array.ctypes.data)
