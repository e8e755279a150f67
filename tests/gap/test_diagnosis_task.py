"""The search of a log for causes, and its answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from flexros.gap import diagnosis_task
from flexros.gap.answer.sensitivity import Sensitivity
from flexros.gap.deadline import Deadline
from flexros.gap.diagnosis_task import DiagnosisTask
from flexros.gap.progress import Stages
from tests.gap.diagnosis_logs import MODEL, settings_of


def test_what_leads_over_all_tolerances_is_what_the_patch_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Probabilities are means over all tolerances where a name depends on them: with these, another one may lead."""
    kept = SimpleNamespace(explanations=SimpleNamespace(beside=None), withdrawn=(), fitted_around=())
    monkeypatch.setattr(diagnosis_task, "confirmed", lambda *_: kept)
    monkeypatch.setattr(diagnosis_task, "sensitivity_of", lambda *_: Sensitivity("mean", (), ("other",)))  # type: ignore[arg-type]
    monkeypatch.setattr(diagnosis_task, "most_probable", lambda _search, mean, _held, other: ("leads", mean, other))
    monkeypatch.setattr(diagnosis_task, "findings_of", lambda *given, **_: given[3])
    monkeypatch.setattr(diagnosis_task, "result_of", lambda findings, *_: findings)
    found: Any = SimpleNamespace(
        null=SimpleNamespace(model=None, data=None), search=None, explanations=None, held_data=None, unknown=None,
        prediction=None, excess=None,
    )  # fmt: skip
    task = DiagnosisTask(MODEL, None, {}, (), settings_of("coulomb_friction"), Deadline(), Stages(None))
    assert task.answered(found) == ("leads", "mean", ("other",))
