"""Many closed loops that differ in parameters, gains, noise or start: blocks of lanes, spread over threads."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from threading import Event
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.compile.loop_arrays import LoopInputs, LoopResult, LoopState
from flexros.errors import InputError, RunError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray, IntArray
    from flexros.compile.loop import LoopKernel

Record = TypeVar("Record", LoopState, LoopInputs)
_SHARED_AXES = {"plant": 1, "controller": 1, "line": 2, "parameters": 1, "gains": 1}  # signals: 2


def run_batch(
    kernel: LoopKernel,
    state: LoopState,
    samples: int,
    inputs: LoopInputs,
    count: int,
    *,
    threads: int | None = None,
    record_pose: bool = True,
    record_states: bool = False,
    progress: Callable[[int], None] | None = None,
) -> LoopResult:
    """Run `count` loops; every array may have a last axis of `count`, or none where all loops share it.

    Args:
        kernel: The loop; its lanes are the size of a block (8 is fast on most processors).
        state: Where to start.
        samples: Number of samples n.
        inputs: Reference, noise, disturbance, parameters, gains.
        count: Number of loops.
        threads: Blocks at the same time; one per processor when None. Results do not depend on it.
        record_pose: Compute and record the tool poses.
        record_states: Record the whole states.
        progress: Called with the number of loops done, in the thread of the caller.

    Returns:
        The result of a run with `count` lanes: encoder (n, M, count), diverged (count,), ...

    Raises:
        InputError: No loops, or an array has the wrong shape.
    """
    if count < 1:
        raise InputError(f"a batch of {count} closed loops is not possible: at least 1 is needed")
    _check_last_axes(state, inputs, count)
    stop = Event()

    def look(_: int) -> None:
        if stop.is_set():
            raise RunError("the batch was interrupted")

    def run(start: int) -> LoopResult:
        chosen = np.minimum(np.arange(start, start + kernel.lanes), count - 1)
        return kernel.run(
            _of_lanes(state, chosen), samples, _of_lanes(inputs, chosen),
            record_pose=record_pose, record_states=record_states, progress=look,
        )  # fmt: skip

    results = []
    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        try:
            for result in pool.map(run, range(0, count, kernel.lanes)):
                results.append(result)
                if progress is not None:
                    progress(min(len(results) * kernel.lanes, count))
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return _joined(results, kernel.lanes, count)


def _check_last_axes(state: LoopState, inputs: LoopInputs, count: int) -> None:
    for record in (state, inputs):
        for field in fields(record):
            array = getattr(record, field.name)
            if array is not None and np.ndim(array) > _SHARED_AXES.get(field.name, 2) and np.shape(array)[-1] != count:
                raise InputError(
                    f"batch of {count} closed loops: {field.name} has shape {np.shape(array)}, "
                    f"its last axis must have length {count}, or be left out where all loops share it"
                )


def _of_lanes(record: Record, chosen: IntArray) -> Record:
    """Take some of the loops out of all arrays that are not shared."""
    cut: dict[str, FloatArray] = {}
    for field in fields(record):
        array = getattr(record, field.name)
        if array is not None and np.ndim(array) > _SHARED_AXES.get(field.name, 2):
            taken = np.asarray(array)[..., chosen]
            cut[field.name] = taken if len(chosen) > 1 else taken[..., 0]
    return replace(record, **cut)


def _joined(results: list[LoopResult], lanes: int, count: int) -> LoopResult:
    """Put blocks side by side and drop the lanes that only filled up the last one."""

    def join(arrays: list[FloatArray]) -> FloatArray:
        blocks = arrays if lanes > 1 else [a[..., np.newaxis] for a in arrays]
        return np.concatenate(blocks, axis=-1)[..., :count]

    def join_recorded(name: str) -> FloatArray | None:
        return None if getattr(results[0], name) is None else join([getattr(r, name) for r in results])

    finals = [r.final for r in results]
    return LoopResult(
        encoder=join([r.encoder for r in results]),
        command=join([r.command for r in results]),
        tool_pose=join_recorded("tool_pose"),
        states=join_recorded("states"),
        final=LoopState(*(join([getattr(final, field.name) for final in finals]) for field in fields(LoopState))),
        diverged=np.concatenate([np.atleast_1d(r.diverged) for r in results])[:count],
    )
