"""The plan contains the requested cases, and their names do not reveal the truth."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from flexros.random_streams import Stream
from flexros.robot import load_robot
from flexros.validation.blind.draw.locations import places_of
from flexros.validation.blind.plan import ALWAYS_STRONG, PlanSettings, plan_cases
from flexros.validation.blind.plant.laws import LIBRARY_LAWS, OUTSIDE_LAWS

SMALL = PlanSettings(per_size=2, nulls=60, unknowns=8, pairs=10)


@pytest.mark.slow
def test_plan_holds_every_effect_at_every_size() -> None:
    cases = plan_cases(SMALL, 3)
    sizes = Counter((case.effects[0], case.size) for case in cases if case.kind == "single")
    assert set(sizes.values()) == {2}
    assert len(sizes) == 3 * len(LIBRARY_LAWS) - 2 * len(ALWAYS_STRONG)
    assert Counter(case.kind for case in cases)["null"] == 60


@pytest.mark.slow
def test_effects_sit_on_robots_that_can_have_them() -> None:
    for case in plan_cases(SMALL, 3):
        assert all(places_of(effect, load_robot(case.robot)) for effect in case.effects)
        assert case.tool or "kinematic_error" not in case.effects


def test_effects_that_no_robot_can_have_are_left_out() -> None:
    cases = plan_cases(PlanSettings({"four_mass": 1.0}, per_size=1, nulls=0, unknowns=2, pairs=3), 1)
    assert {case.robot for case in cases} == {"four_mass"}
    assert not {"gravity_error", "kinematic_error"} & {effect for case in cases for effect in case.effects}


def test_shares_of_robots_and_of_wrong_models_are_kept() -> None:
    cases = plan_cases(SMALL, 3)
    robots = Counter(case.robot for case in cases)
    assert robots["four_mass_linear"] + robots["four_mass"] > 0.6 * len(cases)
    wrong = sum(case.nuisance != "exact" for case in cases)
    assert abs(wrong - len(cases) / 3) < 5


def test_plan_is_a_function_of_seed_and_stream() -> None:
    assert plan_cases(SMALL, 3) == plan_cases(SMALL, 3)
    assert plan_cases(SMALL, 3) != plan_cases(SMALL, 4)
    assert plan_cases(SMALL, 3) != plan_cases(SMALL, 3, Stream.BLIND_DEVELOPMENT)


def test_beginnings_of_the_plan_are_mixed() -> None:
    cases = plan_cases(SMALL, 3)
    nulls = np.array([case.kind == "null" for case in cases], dtype=float)
    assert abs(nulls[: len(cases) // 3].mean() - nulls.mean()) < 0.15


def test_crowds_have_places_and_their_share_of_wrong_models() -> None:
    settings = PlanSettings(per_size=0, nulls=0, unknowns=0, pairs=0, crowds=10, crowd_nuisance=0.4, crowd_outside=0.3)
    cases = plan_cases(settings, 3)
    assert [case.number for case in cases] == list(range(10))
    assert all(case.kind == "crowd" and len(case.places) == len(case.effects) >= 3 for case in cases)
    assert sum(case.nuisance == "tolerance_3" for case in cases) == 4
    assert sum(bool(set(case.effects) & set(OUTSIDE_LAWS)) for case in cases) == 3


def test_crowds_leave_the_other_cases_as_they_are() -> None:
    few = PlanSettings(per_size=0, nulls=3, unknowns=2, pairs=2)
    kinds = [Counter(case.effects for case in plan_cases(one, 3) if case.kind != "crowd") for one in
             (few, replace(few, crowds=4))]  # fmt: skip
    assert kinds[0] == kinds[1]
