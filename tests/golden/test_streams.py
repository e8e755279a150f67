"""Streams of nodes without a log equal the committed ones.

tests/nodes/test_replay.py and test_gap_monitor.py show that the nodes give what is computed here, in every bit.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.golden.streams import FILE, MESSAGES, identification_reference, monitor_messages, monitor_statuses

pytestmark = pytest.mark.slow

GOLDEN = json.loads(FILE.read_text(encoding="utf-8"))


def test_reference_of_an_identification(tmp_path: Path) -> None:
    found, golden = np.array(identification_reference(tmp_path)), np.array(GOLDEN["identification_reference"])
    assert found.shape == golden.shape
    # torques are fourth derivatives of the path: three units in the last place of a position of the plan move position,
    # velocity and torque by 3e-13, 4e-10 and 9e-8 of their largest, and processors differ in the last place
    off = np.abs(found - golden).max(axis=0) / np.abs(golden).max(axis=0)
    assert np.all(off < [1e-15, 3e-12, 4e-9, 9e-7])


def test_statuses_of_a_gap_monitor() -> None:
    found, golden = monitor_statuses(), GOLDEN["monitor_statuses"]
    assert len(found) == len(golden)
    for status, expected in zip(found, golden, strict=True):
        assert status.keys() == expected.keys()
        for key, value in expected.items():
            assert status[key] == (value if isinstance(value, str) else pytest.approx(value, rel=1e-4, abs=1e-9)), key


def test_messages_of_a_gap_monitor() -> None:
    assert monitor_messages() == MESSAGES.read_text(encoding="utf-8").splitlines()
