"""When most of what an answer leaves happened, where that is short."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.gap.answer.short_events import spans
from tests.gap.diagnosis_logs import WHOLE, data_of


@pytest.fixture
def fit() -> Any:
    class Fit:
        """What leaves noise, and more in some samples."""

        def __init__(self) -> None:
            self.more = np.zeros(0)

        def residual(self, data: Any) -> np.ndarray:
            n, M = data.record.position.shape
            left = np.random.default_rng(1).normal(size=(M, n))
            left[0, : len(self.more)] += self.more
            return left.ravel()

    return Fit()


def test_a_push_is_told_with_its_time(fit: Any) -> None:
    data = data_of(length=WHOLE)
    n, T = data.record.n_samples, data.record.sample_time
    fit.more = np.zeros(n)
    fit.more[n // 2 : n // 2 + round(0.1 / T)] = 30.0
    ((first, last),) = spans(data, fit)
    assert first <= n // 2 * T <= last
    assert last - first <= 0.5


def test_what_is_left_everywhere_or_hardly_at_all_is_no_event(fit: Any) -> None:
    data = data_of(length=WHOLE)
    assert spans(data, fit) == []
    fit.more = np.full(data.record.n_samples, 3.0)
    assert spans(data, fit) == []
