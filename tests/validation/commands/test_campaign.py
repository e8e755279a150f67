"""Campaigns from the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from flexros.validation.campaigns.base import AbstractCampaign, CampaignRequest, CampaignResult

Run: TypeAlias = Callable[..., Any]


class Short:
    """A campaign that takes no time."""

    name, question = "short", "How many repetitions?"

    def run(self, request: CampaignRequest) -> CampaignResult:
        request.progress("repetitions", 1, 1)
        number = request.client.submit(abs, -(request.repetitions or 7)).result()
        (request.work / "part.json").write_text("{}")
        return CampaignResult(
            {"short.md": f"# {number}\n", "data/short.json": f"{number}\n"},
            {"number": number},
            (f"There were {number}.",),
        )


AbstractCampaign.register(Short)


@pytest.fixture(autouse=True)
def only_short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.validation.campaigns.base.campaigns", lambda: {"short": Short})


def test_all_campaigns_run_unless_named(flexros: Run, tmp_path: Path) -> None:
    ended = flexros("campaign", "--out", str(tmp_path / "results"))
    assert ended.code == 0, ended.err
    assert "short: How many repetitions?\nThere were 7.\n" in ended.out
    assert (tmp_path / "results" / "short.md").read_text() == "# 7\n"
    assert (tmp_path / "results" / "data" / "short.json").read_text() == "7\n"
    assert (tmp_path / "results" / "campaign_work" / "short" / "part.json").exists()


def test_figures_are_printed_as_json(flexros: Run, tmp_path: Path) -> None:
    work = tmp_path / "work"
    ended = flexros("campaign", "short", "--out", str(tmp_path), "--work", str(work), "--repetitions", "3", "--json")
    assert ended.code == 0, ended.err
    assert json.loads(ended.out) == {"short": {"number": 3}}
    assert (work / "short" / "part.json").exists()


@pytest.mark.slow
def test_unknown_campaign_is_refused(flexros: Run, tmp_path: Path) -> None:
    ended = flexros("campaign", "shirt", "--out", str(tmp_path))
    assert ended.code == 2
    assert ended.err.endswith("unknown campaign 'shirt' in the command line: did you mean 'short'? allowed are short\n")


def test_negative_repetitions_are_refused(flexros: Run, tmp_path: Path) -> None:
    ended = flexros("campaign", "--out", str(tmp_path), "--repetitions", "-1")
    assert ended.code == 2
    assert "--repetitions is -1, but must be 1 or more" in ended.err


@pytest.mark.slow
def test_missing_scheduler_is_told(flexros: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.scheduler.ANSWER", 0.5)
    ended = flexros("campaign", "--out", str(tmp_path), "--scheduler", "tcp://127.0.0.1:1")
    assert ended.code == 2
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:1'" in ended.err


def test_folder_that_cannot_be_made_is_told(flexros: Run, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    ended = flexros("campaign", "--out", str(tmp_path / "file" / "results"))
    assert ended.code == 2
    assert "cannot be made (Not a directory); give one that can be written" in ended.err
