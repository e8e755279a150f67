"""Report of a node."""

from __future__ import annotations

from pathlib import Path

from flexros_nodes.protocol.node_report import NodeReport, read_report


def test_report_survives_its_file(tmp_path: Path) -> None:
    report = NodeReport("plant", 3, "no command", {"samples": 12, "wall_time_s": 0.5})
    report.write(tmp_path / "plant.json")
    assert read_report(tmp_path / "plant.json") == report


def test_node_without_report_has_none(tmp_path: Path) -> None:
    assert read_report(tmp_path / "plant.json") is None
