"""Progress and times of the stages of a diagnosis."""

from __future__ import annotations

import time
from typing import Any

import pytest

from flexros.gap import diagnose as diagnose_module
from flexros.gap import diagnosis_task
from flexros.gap.diagnose import diagnose
from flexros.gap.progress import STEP, Stages
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from tests.gap.rigid_arm import arm, record_of_arm


def test_stages_tell_their_share_of_all() -> None:
    calls: list[tuple[str, float]] = []
    stages = Stages(lambda name, share: calls.append((name, share)))
    stages.begin("first", 0.5)
    stages.inner("part of it", 0.5)
    stages.begin("second", 1.0)
    stages.inner("part of it", 0.5)
    stages.end()
    part = STEP + 0.5 * STEP * (1 - STEP)
    assert [name for name, _ in calls] == ["first", "part of it", "second", "part of it"]
    assert [share for _, share in calls] == pytest.approx([0.0, 0.5 * part, 0.5, 0.5 + 0.5 * part])
    assert set(stages.timings) == {"first", "second"}


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
