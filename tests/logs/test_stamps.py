from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.stamps import sample_number, stamp_ns, stamps_ns


def test_simulated_time_starts_at_one_second():
    assert stamp_ns(0, 5e-4) == 1_000_000_000


@pytest.mark.parametrize("sample_time", [5e-4, 1e-3, 1 / 3000, 0.004])
def test_vector_equals_scalar(sample_time):
    assert stamps_ns(5000, sample_time).tolist() == [stamp_ns(k, sample_time) for k in range(5000)]


def test_rounding_does_not_accumulate():
    assert stamp_ns(3000, 1 / 3000) == 2_000_000_000


def test_stamps_are_integers():
    assert stamps_ns(3, 5e-4).dtype == np.int64


@pytest.mark.parametrize("k", [0, 1, 79_999, 10_000_000])
def test_number_of_a_stamp(k):
    assert sample_number(stamp_ns(k, 1 / 3000), 1 / 3000) == k
