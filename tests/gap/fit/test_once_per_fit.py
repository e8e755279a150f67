"""Results that are kept for a fit and a log."""

from __future__ import annotations

import gc
from typing import Any
from weakref import ref

from flexros.gap.fit.once_per_fit import once_per_fit
from flexros.gap.settings import RankingSettings


class _Part:
    """A fit or a log."""


def test_a_result_is_computed_once_for_each_fit_log_and_settings() -> None:
    asked: list[tuple[Any, ...]] = []

    @once_per_fit
    def count(*what: Any) -> int:
        asked.append(what)
        return len(asked)

    fits: Any = [_Part(), _Part()]
    logs: Any = [_Part(), _Part()]
    questions = [(fit, log, form) for fit in fits for log in logs for form in (None, RankingSettings())]
    first = [count(*question) for question in questions]
    assert first == list(range(1, 9))
    assert [count(*question) for question in questions] == first


def test_nothing_is_kept_of_a_fit_or_a_log_that_is_gone() -> None:
    compute = once_per_fit(lambda *_: 1)
    fit: Any = _Part()
    log: Any = _Part()
    compute(fit, log, None)
    gone = ref(fit), ref(log)
    del fit
    gc.collect()
    assert gone[0]() is None
    del log
    gc.collect()
    assert gone[1]() is None
