from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from tests.gap.report.test_comparison import diagnosis

Flexros = Callable[..., "object"]


def test_compare_prints_writes_and_tells_what_is_missing(flexros: Flexros, tmp_path: Path) -> None:
    for name, level in (("before", 1.0), ("after", 2.0)):
        (tmp_path / name).mkdir()
        content = diagnosis({"motor_1": (level, 0.1)}, rotor=level).model_dump(mode="json", by_alias=True)
        (tmp_path / name / "diagnosis.json").write_text(json.dumps(content))
    folders = [str(tmp_path / name) for name in ("before", "after")]
    ended = flexros("compare", *folders, "--json")
    assert ended.code == 0, ended.err
    told = json.loads(ended.out)
    assert [one["name"] for one in told["diagnoses"]] == ["before", "after"]
    assert told["effects"][0]["values"] == [1.0, 2.0]
    assert told["numbers"][0]["p_same"] < 1e-6
    page = tmp_path / "page.html"
    ended = flexros("compare", *folders, "--report", str(page))
    assert ended.code == 0, ended.err
    assert "1.00 Nm" in ended.out
    assert "2 diagnoses" in page.read_text()
    ended = flexros("compare", folders[0])
    assert ended.code == 2
    assert "at least two folders" in ended.err
