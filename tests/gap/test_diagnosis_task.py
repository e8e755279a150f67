"""A log that is searched again with a smaller tolerance of its torques."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from flexros.gap import diagnosis_task
from flexros.gap.answer.sensitivity import Sensitivity
from flexros.gap.deadline import Deadline
from flexros.gap.diagnosis_task import DiagnosisTask
from flexros.gap.progress import Stages
from tests.gap.diagnosis_logs import MODEL, record_of, settings_of

FRICTION = "coulomb_friction@motor_1:level=0.3"


class SearchedError(Exception):
    """The log is searched."""


@pytest.mark.parametrize(("fitted", "begins"), [(1.0, True), (9.0, False)])
def test_a_search_on_trial_begins_where_its_base_leaves_little_of_the_fitted_log(
    monkeypatch: pytest.MonkeyPatch, fitted: float, begins: bool
) -> None:
    """A delay and a ripple that were missing left four times as much of a faster log, which counts at the end."""

    def explain(*_: Any) -> None:
        raise SearchedError

    settings = settings_of("coulomb_friction")
    record, held = (replace(record_of(FRICTION, length=2.0, seed=seed), imported=True) for seed in (1, 2))
    task = DiagnosisTask(MODEL, held, {}, (), settings, Deadline(), Stages(None))
    begun = task.searched(record).explanations.chosen
    assert begun.hypothesis
    assert task.searched(record, begun).search.base.names == begun.names
    monkeypatch.setattr(diagnosis_task, "beyond_noise", lambda *_: fitted)
    monkeypatch.setattr(diagnosis_task, "_beyond_noise", lambda *_: 99.0)
    monkeypatch.setattr(diagnosis_task, "explain", explain)
    if begins:
        with pytest.raises(SearchedError):
            task.searched(record, begun, 5.0)
    else:
        assert task.searched(record, begun, 5.0).explanations.chosen.names == begun.names


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
        prediction=None, excess=None, closely_tied=None, rest=(),
    )  # fmt: skip
    task = DiagnosisTask(MODEL, None, {}, (), settings_of("coulomb_friction"), Deadline(), Stages(None))
    assert task.answered(found) == ("leads", "mean", ("other",))


def test_an_answer_gives_memory_back_before_it_predicts(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the fits of half an hour at 2 kHz had left behind was a tenth of a gigabyte."""
    asked: list[str] = []
    kept = SimpleNamespace(explanations=SimpleNamespace(beside=None), withdrawn=(), fitted_around=())
    monkeypatch.setattr(diagnosis_task, "confirmed", lambda *_: kept)
    monkeypatch.setattr(diagnosis_task, "give_memory_back", lambda: asked.append("memory"))
    monkeypatch.setattr(diagnosis_task, "sensitivity_of", lambda *_: Sensitivity("mean", (), ()))  # type: ignore[arg-type]
    monkeypatch.setattr(diagnosis_task, "most_probable", lambda *_: None)
    monkeypatch.setattr(diagnosis_task, "findings_of", lambda *_, **__: asked.append("findings"))
    monkeypatch.setattr(diagnosis_task, "result_of", lambda *_: None)
    found: Any = SimpleNamespace(
        null=SimpleNamespace(model=None, data=None), search=None, explanations=None, held_data=None, unknown=None,
        prediction=None, excess=None, closely_tied=None, rest=(),
    )  # fmt: skip
    DiagnosisTask(MODEL, None, {}, (), settings_of(), Deadline(), Stages(None)).answered(found)
    assert asked == ["memory", "findings"]
