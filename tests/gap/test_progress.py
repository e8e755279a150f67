"""Progress and times of the stages of a diagnosis."""

from __future__ import annotations

import pytest

from flexros.gap.progress import STEP, Stages


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
