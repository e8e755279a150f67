"""Groups of repetitions, and their seeds."""

from __future__ import annotations

from flexros.validation.campaigns.coverage.settings import EVALUATION_SEED, CoverageSettings

DEVELOPMENT_SEED = 1000
"""First seed of trials while developing; results are never reported from them."""


def test_every_repetition_has_noise_of_its_own() -> None:
    groups = CoverageSettings(repetitions=200).groups
    seeds = [seed for group in groups for seed in group.noise_seeds]
    assert len(seeds) == len(set(seeds)) == 200
    assert len({group.phase_seed for group in groups}) == 25


def test_more_repetitions_leave_the_groups_before_as_they_are() -> None:
    assert CoverageSettings(repetitions=24).groups == CoverageSettings(repetitions=40).groups[:3]


def test_last_group_may_be_smaller() -> None:
    assert [len(group.noise_seeds) for group in CoverageSettings(repetitions=11).groups] == [8, 3]


def test_groups_can_share_phases() -> None:
    groups = CoverageSettings(repetitions=32, groups_per_phase=2).groups
    assert [group.phase_seed - EVALUATION_SEED for group in groups] == [0, 0, 1, 1]


def test_seeds_of_evaluation_and_development_are_apart() -> None:
    def seeds(first: int) -> set[int]:
        groups = CoverageSettings(repetitions=200, first_seed=first).groups
        return {seed for group in groups for seed in (group.phase_seed, *group.noise_seeds)}

    assert not seeds(DEVELOPMENT_SEED) & seeds(EVALUATION_SEED)
