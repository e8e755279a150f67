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
