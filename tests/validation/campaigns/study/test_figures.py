from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.validation.campaigns.study.figures import (
    hardest_spring,
    normalised_costs,
    of_gears,
    shares,
    sorted_values,
    springs,
    table_1,
)

if TYPE_CHECKING:
    from flexros.validation.campaigns.study.jobs import Study


@pytest.mark.slow
def test_costs_are_divided_by_the_lowest_of_all_models(small_study: Study) -> None:
    lowest = [normalised_costs(small_study, name)[0] for name in small_study.runs]
    assert min(lowest) == 1.0
    assert np.all(np.diff(normalised_costs(small_study, "NLS15U")) >= 0)


def test_springs_of_gears_and_arm_are_told_apart(small_study: Study) -> None:
    names = np.array(small_study.problem.names)
    assert names[springs(small_study)].tolist() == [f"body_{number}.ry.stiffness" for number in (1, 2, 3)]
    assert names[of_gears(small_study)].tolist() == [
        f"body_{number}.ry.{what}" for number in (1, 2) for what in ("stiffness", "damping")
    ]
    assert names[hardest_spring(small_study)] == "body_3.ry.stiffness"


def test_spoilt_models_are_not_counted(small_study: Study) -> None:
    run = small_study.runs["LLS15U"]
    n = len(run.values)
    worse = np.arange(n) < 2
    spoilt = replace(
        run,
        values=run.values * np.where(worse, 3.0, 1.0)[:, None],
        user_cost=run.user_cost.min() * np.where(worse, 10.0, 1.0),
    )
    study = replace(small_study, runs={**small_study.runs, "LLS15U": spoilt})
    before = next(share for share in shares(small_study) if share.kind.name == "LLS15U")
    after = next(share for share in shares(study) if share.kind.name == "LLS15U")
    assert after.reasonable == pytest.approx((n - 2) / n)
    assert after.all_springs < before.all_springs + 1e-12
    assert after.all_springs <= (n - 2) / n


def test_values_are_sorted_by_cost_and_relative_to_the_best(small_study: Study) -> None:
    np.testing.assert_allclose(sorted_values(small_study, "LLS15U")[0], 1.0, rtol=1e-6)


def test_table_has_a_row_per_parameter(small_study: Study) -> None:
    rows = table_1(small_study)
    assert tuple(row.name for row in rows) == small_study.problem.names
    for row in rows:
        assert row.least <= row.median <= row.largest
        assert 0 < row.theory <= row.corrected * (1 + 1e-12)
