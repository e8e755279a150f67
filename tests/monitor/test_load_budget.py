"""The budget of processor time: spent, saved up again, bounded."""

from __future__ import annotations

from flexros.monitor.load_budget import REST, LoadBudget


def test_it_works_until_the_time_is_used_and_again_when_half_is_saved() -> None:
    budget = LoadBudget(0.2)
    assert budget.allows(0.0)
    budget.use(0.2 * REST)
    assert not budget.allows(0.0)
    assert not budget.allows(0.49 * REST)
    assert budget.allows(0.51 * REST)


def test_the_share_is_kept_in_the_long_run() -> None:
    budget, used = LoadBudget(0.1), 0.0
    for step in range(10_000):
        if budget.allows(0.1 * step):
            budget.use(0.05)  # half of the time
            used += 0.05
    assert 0.09 < used / 1000 < 0.11


def test_time_is_not_saved_up_without_end() -> None:
    budget = LoadBudget(0.5)
    budget.allows(0.0)
    assert budget.allows(1e6)
    budget.use(0.5 * REST + 0.01)
    assert not budget.allows(1e6)
