from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.compile import LoopFunctions, LoopKernel, compile_loop
from flexros.compile.batch import run_batch
from flexros.errors import InputError

from .conftest import GAINS, PARAMETERS, SAMPLE_TIME, STATE
from .test_loop import rich_inputs

COUNT = 11


@pytest.fixture(scope="module", params=[1, 4])
def kernel(request: pytest.FixtureRequest, chain: LoopFunctions) -> LoopKernel:
    return compile_loop(chain, sample_time=SAMPLE_TIME, lanes=request.param, delay=SAMPLE_TIME)


def test_every_loop_of_a_batch_equals_its_own_run(chain: LoopFunctions, kernel: LoopKernel) -> None:
    scale = 1 + 0.05 * np.arange(COUNT)
    shared = rich_inputs(30)
    inputs = replace(shared, parameters=np.outer(PARAMETERS, scale), gains=np.outer(GAINS, scale))
    start = kernel.initial_state(np.outer(STATE, scale))
    batch = run_batch(kernel, start, 30, inputs, COUNT, threads=2, record_states=True)
    single = compile_loop(chain, sample_time=SAMPLE_TIME, delay=SAMPLE_TIME)
    assert batch.diverged.tolist() == [-1] * COUNT
    for k in range(COUNT):
        own = replace(shared, parameters=PARAMETERS * scale[k], gains=GAINS * scale[k])
        expected = single.run(single.initial_state(STATE * scale[k]), 30, own, record_states=True)
        for name in ("encoder", "command", "tool_pose", "states"):
            np.testing.assert_array_equal(getattr(batch, name)[..., k], getattr(expected, name))
        np.testing.assert_array_equal(batch.final.plant[..., k], expected.final.plant)
        np.testing.assert_array_equal(batch.final.line[..., k], expected.final.line)


def test_batch_of_one(kernel: LoopKernel) -> None:
    assert run_batch(kernel, kernel.initial_state(STATE), 5, rich_inputs(5), 1).encoder.shape == (5, 2, 1)


def test_progress_counts_loops(kernel: LoopKernel) -> None:
    seen: list[int] = []
    run_batch(kernel, kernel.initial_state(STATE), 5, rich_inputs(5), COUNT, progress=seen.append)
    assert seen[-1] == COUNT
    assert seen == sorted(seen)


def test_interrupt_ends_all_threads(kernel: LoopKernel) -> None:
    def interrupt(done: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_batch(kernel, kernel.initial_state(STATE), 5, rich_inputs(5), 200, threads=2, progress=interrupt)


def test_array_for_another_number_of_loops_is_named(kernel: LoopKernel) -> None:
    inputs = replace(rich_inputs(5), gains=np.outer(GAINS, np.ones(7)))
    with pytest.raises(InputError, match=r"batch of 11 closed loops: gains has shape \(3, 7\)"):
        run_batch(kernel, kernel.initial_state(STATE), 5, inputs, COUNT)


def test_empty_batch_is_refused(kernel: LoopKernel) -> None:
    with pytest.raises(InputError, match="a batch of 0 closed loops is not possible"):
        run_batch(kernel, kernel.initial_state(STATE), 5, rich_inputs(5), 0)
