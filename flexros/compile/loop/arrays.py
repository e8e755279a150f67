"""Input and output arrays of a closed loop.

Internally, every array ends with an axis of lanes; the caller's arrays omit it if the loop has one lane.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.compile.loop.functions import LoopSizes


@dataclass(frozen=True)
class LoopState:
    """State of a loop between two samples.

    Attributes:
        plant: Plant state x, shape (n_states,) or (n_states, lanes).
        controller: Controller state c, shape (n_controller_states,) or (..., lanes).
        line: Past commands [Nm], newest first, shape (line_length, M) or (line_length, M, lanes).
    """

    plant: FloatArray
    controller: FloatArray
    line: FloatArray


@dataclass(frozen=True)
class LoopInputs:
    """Signals and constants of a run. Signals have n rows, or one row for all samples; None is zero.

    Attributes:
        reference: r, shape (n, n_reference), shared by all lanes, or (n, n_reference, lanes).
        noise: Added to the encoder values [rad], then to those of the further sensors, shape (n, n_measured) or
            (n, n_measured, lanes).
        disturbance: Motor torque [Nm] and tool wrench [N, Nm], shape (n, M + 6) or (n, M + 6, lanes).
        parameters: Plant parameters p, shape (n_parameters,) or (n_parameters, lanes).
        gains: Controller parameters g, shape (n_gains,) or (n_gains, lanes).
    """

    reference: FloatArray | None = None
    noise: FloatArray | None = None
    disturbance: FloatArray | None = None
    parameters: FloatArray | None = None
    gains: FloatArray | None = None


@dataclass(frozen=True)
class LoopResult:
    """Recorded signals of a run; rows of samples that were not reached are NaN.

    Attributes:
        encoder: y [rad], shape (n, M) or (n, M, lanes).
        command: u [Nm], shape (n, M) or (n, M, lanes).
        tool_pose: Position [m] and quaternion xyzw, shape (n, 7) or (n, 7, lanes); None if not recorded.
        states: x at the sampling instants, shape (n, n_states) or (n, n_states, lanes); None if not recorded.
        final: State after the last sample; a further run can continue from it.
        diverged: First sample whose state is not finite, -1 if there is none, shape () or (lanes,); counted from the
            start of the run, so it is n if the last step failed.
        further: Values of the further sensors, shape (n, n_further) or (n, n_further, lanes).
    """

    encoder: FloatArray
    command: FloatArray
    tool_pose: FloatArray | None
    states: FloatArray | None
    final: LoopState
    diverged: IntArray
    further: FloatArray


@dataclass
class LoopJob:
    """Contiguous arrays of a run, all with a last axis of lanes (1 for shared signals); the engine fills the outputs.

    Attributes:
        plant: x, changed in place.
        controller: c, changed in place.
        line: Past commands, changed in place.
        parameters: p.
        gains: g.
        reference: Signal of n or 1 rows.
        noise: Signal of n or 1 rows.
        disturbance: Signal of n or 1 rows.
        measured: Output: encoder values, then those of the further sensors.
        command: Output.
        tool_pose: Output, None if not recorded.
        states: Output, None if not recorded.
        diverged: First bad sample per lane, -1 if none.
    """

    plant: FloatArray
    controller: FloatArray
    line: FloatArray
    parameters: FloatArray
    gains: FloatArray
    reference: FloatArray
    noise: FloatArray
    disturbance: FloatArray
    measured: FloatArray
    command: FloatArray
    tool_pose: FloatArray | None
    states: FloatArray | None
    diverged: IntArray

    @property
    def lanes(self) -> int:
        """Number of parallel simulations."""
        return int(self.plant.shape[1])

    @property
    def samples(self) -> int:
        """Number of samples."""
        return int(self.measured.shape[0])

    def part(self, start: int, stop: int) -> LoopJob:
        """Return the job for samples start to stop - 1, on the same memory."""
        cut = {
            name: value[start:stop]
            for name in ("reference", "noise", "disturbance", "measured", "command", "tool_pose", "states")
            if (value := getattr(self, name)) is not None and value.shape[0] == self.samples
        }
        return replace(self, diverged=np.full(self.lanes, -1), **cut)


def make_job(
    sizes: LoopSizes, line_length: int, lanes: int, samples: int, state: LoopState, inputs: LoopInputs,
    *, record_pose: bool, record_states: bool,
) -> LoopJob:  # fmt: skip
    """Check and copy the caller's arrays, and allocate the outputs.

    Raises:
        InputError: An array has the wrong shape; the message names it and the allowed shapes.
    """

    def output(width: int) -> FloatArray:
        return np.full((samples, width, lanes), np.nan)

    return LoopJob(
        plant=_held("state.plant", state.plant, (sizes.state,), lanes),
        controller=_held("state.controller", state.controller, (sizes.controller,), lanes),
        line=_held("state.line", state.line, (line_length, sizes.motors), lanes),
        parameters=_held("parameters", inputs.parameters, (sizes.parameters,), lanes),
        gains=_held("gains", inputs.gains, (sizes.gains,), lanes),
        reference=_signal("reference", inputs.reference, samples, sizes.reference, lanes),
        noise=_signal("noise", inputs.noise, samples, sizes.measured, lanes),
        disturbance=_signal("disturbance", inputs.disturbance, samples, sizes.disturbance, lanes),
        measured=output(sizes.measured),
        command=output(sizes.motors),
        tool_pose=output(sizes.pose) if record_pose else None,
        states=output(sizes.state) if record_states else None,
        diverged=np.full(lanes, -1),
    )


def loop_result(job: LoopJob) -> LoopResult:
    """Return the arrays of a finished job, without the axis of lanes if there is one lane."""
    motors = job.command.shape[1]
    arrays = {field.name: getattr(job, field.name) for field in fields(job)}
    if job.lanes == 1:
        arrays = {name: None if array is None else array[..., 0] for name, array in arrays.items()}
    return LoopResult(
        encoder=arrays["measured"][:, :motors],
        command=arrays["command"],
        tool_pose=arrays["tool_pose"],
        states=arrays["states"],
        final=LoopState(arrays["plant"], arrays["controller"], arrays["line"]),
        diverged=np.asarray(arrays["diverged"]),
        further=arrays["measured"][:, motors:],
    )


def _held(name: str, value: FloatArray | None, shape: tuple[int, ...], lanes: int) -> FloatArray:
    """Copy a constant or state to shape (*shape, lanes)."""
    size = int(np.prod(shape))
    if value is None:
        if size:
            raise InputError(f"closed loop: {name} is missing, it needs {size} values")
        return np.zeros((*shape, lanes))
    array = np.asarray(value, dtype=np.float64)
    if array.shape == shape:
        array = np.repeat(array[..., np.newaxis], lanes, axis=-1)
    if array.shape != (*shape, lanes):
        raise InputError(
            f"closed loop: {name} has shape {array.shape}, needed is {shape}, or {(*shape, lanes)} for one set per lane"
        )
    return np.array(array, order="C")


def _signal(name: str, value: FloatArray | None, samples: int, width: int, lanes: int) -> FloatArray:
    """Return a signal as (n or 1, width, lanes or 1)."""
    if value is None:
        return np.zeros((1, width, 1))
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    rows, last = array.shape[0], array.shape[-1]
    if array.ndim != 3 or rows not in (1, samples) or array.shape[1] != width or last not in (1, lanes):
        raise InputError(
            f"closed loop: {name} has shape {np.shape(value)}, needed is ({samples}, {width}) or (1, {width}), "
            f"with a last axis of {lanes} for one signal per lane"
        )
    return np.ascontiguousarray(array)
