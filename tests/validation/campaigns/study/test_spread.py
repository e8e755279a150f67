from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.validation.campaigns.study.spread import estimated_spread

if TYPE_CHECKING:
    from flexros.validation.campaigns.study.jobs import Study

pytestmark = pytest.mark.slow


def test_spread_is_that_of_its_seed(small_study: Study) -> None:
    first, again, other = (estimated_spread(small_study.problem, small_study.best, 3, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.all(first != other)


def test_one_draw_is_refused(small_study: Study) -> None:
    with pytest.raises(InputError, match=r"1 draws were requested, allowed are 2 or more"):
        estimated_spread(small_study.problem, small_study.best, 1, 0)


def test_responses_without_covariance_are_refused(small_study: Study) -> None:
    bare = tuple(replace(each, total_error=None, noise_error=None) for each in small_study.problem.responses)
    with pytest.raises(InputError, match=r"noise cannot be drawn anew"):
        estimated_spread(replace(small_study.problem, responses=bare), small_study.best, 2, 0)
