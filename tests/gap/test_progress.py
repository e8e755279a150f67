"""Progress and times of the stages of a diagnosis."""

from __future__ import annotations

from flexros.gap.progress import Stages


def test_stages_tell_their_share_of_all() -> None:
    calls: list[tuple[str, float]] = []
    stages = Stages(lambda name, share: calls.append((name, share)))
    stages.begin("first", 0.5)
    stages.inner("part of it", 0.5)
    stages.begin("second", 1.0)
    stages.inner("part of it", 0.5)
    stages.end()
    assert calls == [("first", 0.0), ("part of it", 0.3125), ("second", 0.5), ("part of it", 0.8125)]
    assert set(stages.timings) == {"first", "second"}
