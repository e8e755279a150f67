"""The campaign of path errors writes its page. Its figures are tested in `test_comparison.py`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.scheduler import connected
from flexros.validation.campaigns.base import CampaignRequest
from flexros.validation.campaigns.path_improvement import PathErrors
from flexros.validation.campaigns.path_improvement.comparison import Improvement, PathImprovement

FOUND = Improvement(
    {"body_1.ry.stiffness": (1e5, 8e4, 8.04e4, 0.004)},
    (PathImprovement("circle_dae", "dae", 5e-3, 2.5e-4, 2e-4),),
)


def test_page_shows_path_errors_and_values(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(
        "flexros.validation.campaigns.path_improvement.comparison.identify_and_compare", lambda *arguments: FOUND
    )
    with connected(threads=1) as client:
        result = PathErrors().run(CampaignRequest(tmp_path, client))
    page = result.files["identification_path.md"]
    assert "| circle_dae | dae | 5 | 0.25 | 0.2 | 20 |" in page
    assert "| body_1.ry.stiffness | 100000 | 80000 | 80400 | 0.4 | 0.5 |" in page
    assert json.loads(result.files["data/identification_path.json"])["paths"][0]["identified"] == 2.5e-4
    assert result.summary[0].startswith("circle_dae: largest path error 5 mm with the nominal model, 0.25 mm")
