"""Torque or current, on the record of a UR5e that MuJoCo simulates."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexros.record.proposal.effort_unit import effort_unit
from flexros.record.record import Record

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("size", "unit"), [(1.0, "Nm"), (1e3, "mNm"), (1e-3, "kNm"), (0.1, "A"), (20.0, "A")])
def test_unit_by_the_size_of_the_effort(ur5e_record: Record, ur5e: Any, size: float, unit: str) -> None:
    assert effort_unit(replace(ur5e_record, torque=size * ur5e_record.torque), ur5e).unit == unit


def test_noise_shows_nothing(ur5e_record: Record, ur5e: Any) -> None:
    noise = np.random.default_rng(2).normal(size=ur5e_record.torque.shape)
    found = effort_unit(replace(ur5e_record, torque=noise), ur5e)
    assert (found.unit, found.compared) == ("Nm", {})
    assert np.isnan(found.level)


def test_a_wrist_that_shows_nothing_counts_like_the_others(ur5e_record: Record, ur5e: Any) -> None:
    torque = ur5e_record.torque.copy()
    torque[:, 5] = torque[:, 5].std() * np.random.default_rng(3).normal(size=len(torque))
    found = effort_unit(replace(ur5e_record, torque=-torque), ur5e)
    assert ur5e.joint_names[5] not in found.compared
    assert found.signs == (-1,) * 6
    assert effort_unit(replace(ur5e_record, torque=torque), ur5e).signs == (1,) * 6
    one = np.array([1, -1, 1, 1, 1, 1])
    assert effort_unit(replace(ur5e_record, torque=one * torque), ur5e).signs == tuple(one)


def test_one_joint_of_six_shows_no_unit(ur5e_record: Record, ur5e: Any) -> None:
    torque = np.random.default_rng(3).normal(size=ur5e_record.torque.shape) * ur5e_record.torque.std(axis=0)
    torque[:, 1] = 0.3 * ur5e_record.torque[:, 1]
    found = effort_unit(replace(ur5e_record, torque=torque), ur5e)
    assert list(found.compared) == [ur5e.joint_names[1]]
    assert (found.unit, found.alone) == ("Nm", True)
    assert effort_unit(replace(ur5e_record, torque=torque), ur5e, current=True).unit == "A"
