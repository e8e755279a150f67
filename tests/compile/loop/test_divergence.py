from __future__ import annotations

import numpy as np
import pytest

from flexros.compile import LoopInputs, compile_loop
from flexros.compile.loop import kernel as kernel_module
from tests.compile.conftest import unstable


def test_run_ends_at_the_first_state_that_is_not_finite() -> None:
    kernel = compile_loop(unstable(), sample_time=0.1)
    inputs = LoopInputs(reference=np.zeros((1, 1)), parameters=np.array([1.0]))
    result = kernel.run(kernel.initial_state([1.0]), 50, inputs)
    bad = int(result.diverged)
    assert 4 < bad < 20
    assert np.isfinite(result.encoder[:bad]).all()
    assert np.isnan(result.encoder[bad:]).all()
    assert not np.isfinite(result.final.plant).all()


def test_divergence_is_counted_from_the_start_of_a_sliced_run(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = compile_loop(unstable(), sample_time=0.1)
    inputs = LoopInputs(reference=np.zeros((1, 1)), parameters=np.array([1.0]))
    whole = kernel.run(kernel.initial_state([1.0]), 50, inputs)
    monkeypatch.setattr(kernel_module, "_SLICE_WORK", 3)
    assert kernel.run(kernel.initial_state([1.0]), 50, inputs).diverged == whole.diverged


def test_a_lane_that_diverges_does_not_stop_the_others() -> None:
    kernel = compile_loop(unstable(), sample_time=0.1, lanes=4)
    inputs = LoopInputs(reference=np.zeros((1, 1)), parameters=np.array([[0.0, 1.0, -1.0, 2.0]]))
    result = kernel.run(kernel.initial_state([1.0]), 50, inputs)
    assert result.diverged[0] == result.diverged[2] == -1
    assert 0 < result.diverged[3] < result.diverged[1] < 50
    assert np.isfinite(result.encoder[:, 0, [0, 2]]).all()
