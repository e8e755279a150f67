"""Progress and times of the stages of a diagnosis."""

from __future__ import annotations

import time
from typing import Any

import pytest

from flexros.gap import diagnose as diagnose_module
from flexros.gap import diagnosis_task
from flexros.gap.diagnose import diagnose
from flexros.gap.progress import BEGINS, Stages
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from tests.gap.rigid_arm import arm, record_of_arm


def test_stages_tell_their_share_of_all() -> None:
    calls: list[tuple[str, float]] = []
    stages = Stages(lambda name, share: calls.append((name, share)))
    stages.begin("first", 0.5)
    stages.inner("all of it", 0.5)
    stages.begin("second", 1.0)
    stages.inner("all of it", 0.5)
    stages.end()
    assert [name for name, _ in calls] == ["first", "all of it", "second", "all of it"]
    assert [share for _, share in calls] == pytest.approx([0.0, 0.25, 0.5, 0.75])
    assert set(stages.timings) == {"first", "second"}


def test_a_step_of_a_search_stands_where_it_usually_begins_and_the_share_never_falls() -> None:
    """With each new step a fifth of what was left had been told, so that 94 % stood for half of a search."""
    told: dict[str, float] = {}
    stages = Stages(lambda name, share: told.update({name: share}))
    stages.begin("causes", 1.0)
    for step in ("candidates", "single effects", "best effects", "effects together", "effects left out"):
        stages.inner(step, 1.0)
    assert told["effects together"] == pytest.approx(BEGINS["effects exchanged"])
    assert told["effects left out"] == told["effects together"]
    stages.inner("effects on held-out data", 0.0)
    assert told["effects on held-out data"] == BEGINS["effects on held-out data"]


def test_stages_that_are_gone_through_again_share_what_is_left() -> None:
    calls: list[tuple[str, float]] = []
    stages = Stages(lambda name, share: calls.append((name, share)))
    stages.begin("first", 0.5)
    stages.begin("second", 1.0)
    stages.end()
    before = stages.timings["first"]
    stages.again()
    stages.begin("first", 0.5)
    stages.begin("second", 1.0)
    stages.end()
    assert calls == [("first", 0.0), ("second", 0.5), ("first", 0.5), ("second", 0.75)]
    assert stages.timings["first"] > before


@pytest.mark.slow
def test_a_log_that_is_weighed_again_adds_to_the_times_of_its_stages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its torques are found to act earlier than they are noted, so that all begins anew."""
    shifts = iter((-0.5, None))
    asked: list[float] = []
    calls: list[tuple[str, float, float]] = []

    def shift_of_noted(*_: Any) -> float | None:
        asked.append(time.monotonic())
        return next(shifts, None)

    monkeypatch.setattr(diagnosis_task, "shift_of_noted", shift_of_noted)
    monkeypatch.setattr(diagnose_module, "shift_of_noted", lambda *_: None)
    settings = DiagnosisSettings(next_experiment=None, search=SearchSettings(effects=("coulomb_friction",)))
    result = diagnose(
        record_of_arm(imported=True),
        arm(),
        settings=settings,
        progress=lambda name, share: calls.append((name, share, time.monotonic())),
    )
    shares = [share for _, share, _ in calls]
    assert shares == sorted(shares)
    assert [name for name, _, _ in calls].count("nominal model") == 2
    assert result.timings["nominal model"] > asked[1] - calls[0][2]


def test_a_fit_tells_the_share_of_its_iterations_and_hears_when_it_must_end() -> None:
    calls: list[tuple[str, float]] = []
    stages = Stages(lambda name, share: calls.append((name, share)))
    stages.begin("nominal model", 0.5)
    ends = iter([False, False, True])
    stop = stages.of_fit(4, lambda: next(ends))
    assert [stop(), stop(), stop()] == [False, False, True]
    assert calls == [("nominal model", share) for share in (0.0, 0.125, 0.25, 0.375)]
