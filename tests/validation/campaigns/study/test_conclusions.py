from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.campaigns.study.conclusions import conclusion_rows, conclusions

if TYPE_CHECKING:
    from flexros.validation.campaigns.study.jobs import Study


def test_all_conclusions_of_the_paper_are_compared(small_study: Study) -> None:
    found = conclusions(small_study)
    assert len(found) == 7
    assert "published 80%, 2%" in found[1].here


def test_equal_shares_do_not_reproduce_a_conclusion(small_study: Study) -> None:
    runs = dict.fromkeys(small_study.runs, small_study.runs["LLS15U"])
    found = conclusions(replace(small_study, runs=runs))
    assert [one.holds for one in found[:4]] == [False] * 4
    text = "\n".join(conclusion_rows(replace(small_study, runs=runs)))
    assert "more than one position is needed; phase" in text
    assert "Why they differ" in text


def test_an_estimator_that_fails_from_all_starts_reproduces_it(small_study: Study) -> None:
    good = small_study.runs["LLS15U"]
    low = np.full_like(good.user_cost, good.user_cost.min())
    best = replace(good, user_cost=low, peer_cost=low)
    failed = replace(good, user_cost=1e3 * low, peer_cost=1e3 * low)
    runs = {name: best if name == "LLS15U" else failed for name in small_study.runs}
    found = conclusions(replace(small_study, runs=runs))
    assert [one.holds for one in found[:4]] == [True] * 4


def test_theory_twice_too_small_is_no_good_indication(small_study: Study) -> None:
    assert not conclusions(replace(small_study, theory=small_study.spread / 2.1))[-1].holds
    assert conclusions(replace(small_study, theory=small_study.spread / 1.5))[-1].holds
