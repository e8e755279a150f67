from __future__ import annotations

import json
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from flexros.cli.json_output import OUTPUTS

pytestmark = pytest.mark.slow


def test_friction_of_runs_at_several_speeds(flexros, tmp_path: Path) -> None:
    folders = []
    for speed in ("0.3", "1.0"):
        folders.append(str(tmp_path / speed))
        change = f"trajectory.time_law.speed={speed}"
        ran = flexros("run", "friction_two_mass", "--set", change, "--transport", "direct", "--out", folders[-1])
        assert ran.code == 0, ran.err
    ended = flexros("identify", "friction", *folders, "--json")
    assert ended.code == 0, ended.err
    record = json.loads(ended.out)
    assert len(record["points"]) == 4
    assert [law["equation"] for law in record["laws"]] == ["3.14"]
    assert record["laws"][0]["parameters"]["f_c"]["value"] == pytest.approx(7.0, rel=0.2)
    TypeAdapter(OUTPUTS["identify friction"]).validate_python(record)
    report = tmp_path / "friction.html"
    ended = flexros("identify", "friction", *folders, "--report", str(report))
    assert ended.code == 0, ended.err
    assert "Friction of motor_1" in report.read_text(encoding="utf-8")
