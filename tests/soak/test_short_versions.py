"""Short versions of the parts of the endurance test; the full ones run by `make soak`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

from tests.soak import bad_transport, foreign_senders, frozen_partners, full_disk, killed_nodes, long_runs, many_runs
from tests.soak.own_mounts import mounts_are_allowed
from tests.soak.result import Result

pytestmark = [pytest.mark.ros, pytest.mark.slow]

PARTS: dict[str, Callable[[Path], Result]] = {
    "orders": lambda folder: killed_nodes.killed_in_order(
        folder, [("feedforward", "recorder", "plant", "controller")], 0.2
    ),
    "frozen": lambda folder: frozen_partners.frozen(folder, ["controller"], [frozen_partners.SHORT], 2.0),
    "bad_transport": lambda folder: bad_transport.disturbed(folder, 0.2, [1]),
    "flood": lambda folder: foreign_senders.flooded(folder, ["not_finite"], 1.0, 2000.0),
    "in_a_row": lambda folder: many_runs.in_a_row(folder, 3, 1, 0),
    "side_by_side": lambda folder: many_runs.side_by_side(folder, 2, 1, 0.5),
}


@pytest.mark.parametrize("part", PARTS)
def test_everything_is_as_it_must_be(part: str, tmp_path: Path) -> None:
    result = PARTS[part](tmp_path)
    assert result.wrong == []
    assert result.rows


def test_disk_that_is_full_is_survived(tmp_path: Path) -> None:
    if not mounts_are_allowed(tmp_path):
        pytest.skip("this user may not mount a file system; test_faults.py limits the size of files instead")
    assert full_disk.full_disk(tmp_path, ["composed"], ["2m"]).wrong == []


def test_long_run_loses_nothing(tmp_path: Path) -> None:
    result = long_runs.long_run(tmp_path, "composed", 4.0, 0.01, False)
    assert [row[0] for row in result.rows] == ["run", "log"]
    assert result.rows[-1][-1] == "ok"
