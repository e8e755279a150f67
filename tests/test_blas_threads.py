"""BLAS uses one thread where computations run side by side, and as many as before afterwards."""

from __future__ import annotations

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from flexros.blas_threads import one_blas_thread
from flexros.gap import diagnosis_task
from flexros.gap.diagnose import diagnose
from flexros.gap.settings import DiagnosisSettings
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import record_of


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_threads_are_limited_in_the_block_alone() -> None:
    assert np.linalg.det(np.eye(2)) == 1.0  # BLAS is loaded
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        with one_blas_thread():
            assert threads() == {1}
        assert threads() == before


@pytest.mark.slow
def test_fits_of_a_diagnosis_have_one_thread_each(monkeypatch: pytest.MonkeyPatch) -> None:
    class EndError(Exception):
        pass

    def explain(*_: object) -> None:
        assert threads() == {1}
        raise EndError

    monkeypatch.setattr(diagnosis_task, "explain", explain)
    with threadpool_limits(limits=2, user_api="blas"), pytest.raises(EndError):
        diagnose(record_of(), load_robot("four_mass_linear"), settings=DiagnosisSettings())
