"""A predictor of constant gain around a plant, as one kernel of machine code.

At every sampling instant t_k = k T, with the recorded positions y_k and torques u_k:

    e_k = (y_k - sensor(encoder(x_k))) v_k,   z_k = tool pose of x_k
    x_k <- x_k + K e_k
    x_k+1: as in the closed loop of kernel.py, under the delayed torque u_k

v_k is 1 for a measured sample and 0 otherwise, so that the model runs without correction through gaps. A gain of zero
yields the free response. Several lanes run in parallel, each with its own parameters and, optionally, torques.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.command_delay import split_delays
from flexros.compile.ir_text import IrBlock
from flexros.compile.loop.divergence import stop_when_diverged
from flexros.compile.loop.driver import ADVANCE, MEASURE, LoopDriver
from flexros.compile.loop.functions import loop_sizes
from flexros.compile.loop.machine_code import add_functions
from flexros.compile.module_builder import ModuleBuilder, check_lanes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.compile.loop.functions import LoopFunctions, LoopSizes

PREDICT = "loop.predict"
JOB_FIELDS = (
    "samples", "plant", "line", "parameters", "gain", "torque", "position", "valid",
    "innovation", "pose_rows", "tool_pose", "states", "diverged", "torque_shared",
)  # fmt: skip
"""Entries of the job of `loop.predict`, 64 bits each: numbers, addresses (0: not recorded), flags."""


@dataclass(frozen=True)
class LoopPrediction:
    """Result of a prediction; rows of samples after a divergence are NaN.

    Attributes:
        innovation: Prediction errors e [rad or m], shape (n, M, lanes).
        tool_pose: Predicted poses [m and quaternion xyzw] of the requested samples, shape (m, 7, lanes); None if none
            was requested.
        states: States after the correction, shape (n, n_states, lanes); None if not requested.
        final: State at the instant after the last sample, shape (n_states, lanes).
        diverged: First sample whose state is not finite, -1 if there is none, shape (lanes,).
    """

    innovation: FloatArray
    tool_pose: FloatArray | None
    states: FloatArray | None
    final: FloatArray
    diverged: IntArray


class PredictionLoop:
    """A predictor ready to run; stateless and thread-safe, runs release the GIL.

    Args:
        functions: The plant; its controller is not used.
        sample_time: Time T between two samples [s].
        delay: Time until a command acts [s], zero or more; of all motors, or of each.
        substeps: Runge-Kutta steps per sample (per part of it where the delay splits it).
        lanes: Parallel predictors: 1, 2, 4, 8, 16.
    """

    def __init__(
        self,
        functions: LoopFunctions,
        *,
        sample_time: float,
        delay: float | Sequence[float] = 0.0,
        substeps: int = 1,
        lanes: int = 1,
    ) -> None:
        check_lanes(lanes)
        self.sizes: LoopSizes = loop_sizes(functions)
        self.lanes = lanes
        timing = split_delays(delay, sample_time)
        self.line_length = timing.line_length
        builder = ModuleBuilder()
        driver = LoopDriver(add_functions(builder, functions, lanes), self.sizes, timing, substeps, lanes)
        builder.add_text(driver.text())
        builder.add_text(_predict_text(self.sizes, lanes))
        self._code = builder.build()
        self._predict = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(self._code.address(PREDICT))

    def run(
        self,
        start: FloatArray,
        parameters: FloatArray,
        gain: FloatArray,
        torque: FloatArray,
        position: FloatArray,
        valid: FloatArray,
        *,
        past: FloatArray | None = None,
        pose_samples: IntArray | None = None,
        record_states: bool = False,
    ) -> LoopPrediction:
        """Predict all samples.

        Args:
            start: State before the first sample, shape (n_states,) or (n_states, lanes).
            parameters: Parameters of the plant, shape (n_parameters, lanes).
            gain: Gain K, shape (n_states, M).
            torque: Torques, shape (n, M), or (n, M, lanes) for one record per lane.
            position: Measured positions [rad or m], shape (n, M).
            valid: 1 for a measured sample, 0 otherwise, shape (n,).
            past: Torques before the first sample, newest first, shape (line_length, M) or (line_length, M, lanes);
                default: the first one.
            pose_samples: Samples whose tool pose is recorded, increasing, shape (m,); None for none.
            record_states: Whether to record the states.
        """
        signal = np.ascontiguousarray(torque, dtype=float)
        prediction = self._allocated(start, len(position), pose_samples, record_states)
        arrays = [
            prediction.final,
            self._line(signal[:1] if past is None else past),
            np.array(parameters, dtype=float, order="C").reshape(self.sizes.parameters, self.lanes),
            np.array(gain, dtype=float, order="C").reshape(self.sizes.state, self.sizes.motors),
            signal,
            np.ascontiguousarray(position, dtype=float),
            np.ascontiguousarray(valid, dtype=float),
            prediction.innovation,
            _pose_rows(len(position), pose_samples),
            prediction.tool_pose,
            prediction.states,
            prediction.diverged,
        ]
        self._call(len(position), arrays, torque_shared=signal.ndim == 2)
        return prediction

    def _allocated(
        self, start: FloatArray, n: int, pose_samples: IntArray | None, record_states: bool
    ) -> LoopPrediction:
        """Allocate the arrays that the kernel fills; `final` holds the initial state."""
        sizes, lanes = self.sizes, self.lanes
        state = np.asarray(start, dtype=float)
        state = state[:, None] if state.ndim == 1 else state
        return LoopPrediction(
            innovation=np.full((n, sizes.motors, lanes), np.nan),
            tool_pose=None if pose_samples is None else np.full((len(pose_samples), sizes.pose, lanes), np.nan),
            states=np.full((n, sizes.state, lanes), np.nan) if record_states else None,
            final=np.array(np.broadcast_to(state, (sizes.state, lanes)), order="C"),
            diverged=np.full(lanes, -1, dtype=np.int64),
        )

    def _line(self, past: FloatArray) -> FloatArray:
        """Return the line of delayed commands for every lane."""
        before = np.asarray(past, dtype=float)
        before = before[..., None] if before.ndim == 2 else before
        return np.array(np.broadcast_to(before, (self.line_length, self.sizes.motors, self.lanes)), order="C")

    def _call(self, n: int, arrays: Sequence[FloatArray | IntArray | None], *, torque_shared: bool) -> None:
        """Run the kernel over n samples, with the arrays in the order of the fields of its job."""
        addresses = [0 if array is None else int(array.ctypes.data) for array in arrays]
        entries = np.array([n, *addresses, int(torque_shared)], dtype=np.int64)
        self._predict(entries.ctypes.data)


def _pose_rows(n: int, pose_samples: IntArray | None) -> IntArray:
    """Return the row of the recorded poses for every sample, -1 if it is not recorded."""
    rows = np.full(n, -1, dtype=np.int64)
    if pose_samples is not None:
        rows[pose_samples] = np.arange(len(pose_samples))
    return rows


def _predict_text(sizes: LoopSizes, lanes: int) -> str:
    """Write `i64 predict(job)`, which returns the number of samples; it ends early once every lane has diverged."""
    block = IrBlock(lanes)
    scalar = block.of_lanes(1)
    m = sizes.motors
    job = {name: _entry(block, index) for index, name in enumerate(JOB_FIELDS)}
    zeros = {name: _zeros(block, count * lanes) for name, count in (("noise", m), ("disturbance", sizes.disturbance))}
    y, u = (block.value(f"alloca double, i64 {m * lanes}, align 64") for _ in range(2))
    x, p, line = job["plant"], job["parameters"], job["line"]
    shared = block.value(f"icmp ne i64 {job['torque_shared']}, 0")
    width = block.value(f"select i1 {shared}, i64 {m}, i64 {m * lanes}")
    with block.loop(0, job["samples"]) as k:
        torque = block.pointer(job["torque"], block.value(f"mul nsw i64 {k.index}, {width}"), "double")
        with block.when(shared):
            for motor in range(m):
                block.store(block.splat(scalar.load(torque, motor)), u, motor)
        torque = block.value(f"select i1 {shared}, ptr {u}, ptr {torque}")
        pose = _pose_address(block, job, k.index, sizes.pose * lanes)
        block.emit(f"call void @{MEASURE}(ptr {x}, ptr {zeros['noise']}, ptr {p}, ptr {y}, ptr {pose})")
        errors = _correct(block, job, k.index, y, sizes)
        for motor, error in enumerate(errors):
            block.store(error, _row(block, job["innovation"], k.index, m * lanes), motor)
        states = _row(block, job["states"], k.index, sizes.state * lanes)
        with block.when(block.value(f"icmp ne ptr {job['states']}, null")):
            size = 8 * sizes.state * lanes
            block.emit(f"call void @llvm.memcpy.p0.p0.i64(ptr {states}, ptr {x}, i64 {size}, i1 false)")
        block.emit(f"call void @{ADVANCE}(ptr {x}, ptr {line}, ptr {torque}, ptr {zeros['disturbance']}, ptr {p})")
        stop_when_diverged(block, sizes.state, x, job["diverged"], k.index)
    return f"define i64 @{PREDICT}(ptr %job) nounwind {{\nentry:\n{block.text()}\n  ret i64 {job['samples']}\n}}"


def _correct(block: IrBlock, job: dict[str, str], k: str, y: str, sizes: LoopSizes) -> list[str]:
    """Write the prediction errors of sample k and the correction of the state."""
    scalar = block.of_lanes(1)
    valid = block.splat(scalar.load(job["valid"], k))
    measured = block.pointer(job["position"], block.value(f"mul nsw i64 {k}, {sizes.motors}"), "double")
    errors = [
        block.mul(valid, block.sub(block.splat(scalar.load(measured, motor)), block.load(y, motor)))
        for motor in range(sizes.motors)
    ]
    for state in range(sizes.state):
        value = block.load(job["plant"], state)
        for motor, error in enumerate(errors):
            gain = block.splat(scalar.load(job["gain"], state * sizes.motors + motor))
            value = block.add(value, block.mul(gain, error))
        block.store(value, job["plant"], state)
    return errors


def _entry(block: IrBlock, index: int) -> str:
    number = JOB_FIELDS[index] in ("samples", "torque_shared")
    return block.value(f"load {'i64' if number else 'ptr'}, ptr {block.pointer('%job', index, 'i64')}, align 8")


def _zeros(block: IrBlock, count: int) -> str:
    address = block.value(f"alloca double, i64 {count}, align 64")
    block.emit(f"call void @llvm.memset.p0.i64(ptr {address}, i8 0, i64 {8 * count}, i1 false)")
    return address


def _row(block: IrBlock, base: str, k: str, width: int) -> str:
    return block.pointer(base, block.value(f"mul nsw i64 {k}, {width}"), "double")


def _pose_address(block: IrBlock, job: dict[str, str], k: str, width: int) -> str:
    """Return the address of the pose of sample k, null if it is not recorded."""
    row = block.value(f"load i64, ptr {block.pointer(job['pose_rows'], k, 'i64')}, align 8")
    wanted = block.value(f"icmp sge i64 {row}, 0")
    return block.value(f"select i1 {wanted}, ptr {_row(block, job['tool_pose'], row, width)}, ptr null")
