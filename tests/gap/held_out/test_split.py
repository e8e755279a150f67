"""The part of a log that is held out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.held_out.split import split
from flexros.record.record import Record
from tests.gap.rigid_arm import record_of_arm


def resting(before: int, after: int) -> Record:
    """Return a log of 4000 samples in motion that rests before and after it [samples]."""
    record = record_of_arm()
    ends = np.repeat(record.position[:1], before, axis=0), np.repeat(record.position[-1:], after, axis=0)
    n = before + record.n_samples + after
    return replace(
        record,
        position=np.concatenate([ends[0], record.position, ends[1]]),
        torque=np.zeros((n, 2)),
        valid=np.ones(n, dtype=bool),
    )


@pytest.mark.parametrize(
    ("before", "after", "border"),
    [(0, 0, 3000), (0, 400, 3300), (0, 4000, 3000), (16_000, 0, 19_000)],
    ids=["motion to the end", "a rest at the end", "a rest in all of the last part", "one in all of the first"],
)
def test_some_motion_is_held_out_and_some_is_not(before: int, after: int, border: int) -> None:
    fitted, held = split(resting(before, after), 0.75)
    assert fitted.n_samples == pytest.approx(border, abs=25)
    assert fitted.n_samples + held.n_samples == before + 4000 + after


def test_samples_that_do_not_count_are_no_motion() -> None:
    record = resting(0, 4000)
    spoilt = record.position.copy()
    spoilt[-100:] += 0.5
    fitted, _ = split(replace(record, position=spoilt, valid=np.arange(8000) < 7900), 0.75)
    assert fitted.n_samples == pytest.approx(3000, abs=25)


def test_a_log_without_motion_is_divided_by_its_samples() -> None:
    record = resting(0, 0)
    still = replace(record, position=np.zeros_like(record.position))
    assert split(still, 0.75)[0].n_samples == 3000
