from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError, RunError
from flexros.identify.graybox.fit import fit
from flexros.identify.graybox.multistart import best, multistart, random_starts
from flexros.identify.graybox.problem import GrayBoxProblem, graybox_problem
from flexros.scheduler import connected

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot


@pytest.fixture(scope="module")
def problem(e12: Robot, e12_names: list[str], noisy_e12: tuple[FrequencyResponse, ...]) -> GrayBoxProblem:
    return graybox_problem(e12, noisy_e12, e12_names)


def test_starts_are_within_a_decade_and_fill_it(problem: GrayBoxProblem) -> None:
    decades = np.log10(random_starts(problem, 500, seed=1) / problem.scale.nominal)
    assert np.all(np.abs(decades) <= 1.0)
    np.testing.assert_allclose(
        np.quantile(decades, [0.1, 0.5, 0.9], axis=0), [[-0.8] * 6, [0] * 6, [0.8] * 6], atol=0.1
    )


def test_first_starts_do_not_depend_on_their_number(problem: GrayBoxProblem) -> None:
    np.testing.assert_array_equal(random_starts(problem, 9, seed=1)[:3], random_starts(problem, 3, seed=1))


def test_linear_parameters_start_around_their_value(e12: Robot, exact_e12: tuple[FrequencyResponse, ...]) -> None:
    problem = graybox_problem(e12, exact_e12, ["body_2.length.x", "motor_1.viscous_friction"])
    starts = random_starts(problem, 200, seed=0)
    assert np.all((starts[:, 0] >= 0.0) & (starts[:, 0] <= 2.0))
    assert np.all(starts[:, 1] >= 0.0)


def test_starts_lie_within_given_bounds_and_fill_them(problem: GrayBoxProblem) -> None:
    bounds = {"body_1.ry.stiffness": (8e4, 2e5), "body_2.ry.stiffness": (5e5, 4e6), "body_3.ry.damping": (1e-2, 1e3)}
    starts = random_starts(problem, 300, seed=1, bounds=bounds)
    nominal = dict(zip(problem.names, problem.scale.nominal, strict=True))
    drawn = dict(zip(problem.names, starts.T, strict=True))
    assert 8e4 <= drawn["body_1.ry.stiffness"].min() < 8.2e4 < 1.9e5 < drawn["body_1.ry.stiffness"].max() <= 2e5
    assert 5e5 <= drawn["body_2.ry.stiffness"].min() < 5.2e5 < 3.8e6 < drawn["body_2.ry.stiffness"].max() <= 4e6
    assert nominal["body_3.ry.damping"] / 10 <= drawn["body_3.ry.damping"].min()
    assert drawn["body_3.ry.damping"].max() <= nominal["body_3.ry.damping"] * 10
    for each in multistart(problem, 3, seed=1, bounds=bounds):
        assert each.converged


@pytest.mark.parametrize("threads", [1, 3])
def test_fits_come_in_the_order_of_their_starts_whatever_the_threads(problem: GrayBoxProblem, threads: int) -> None:
    starts = random_starts(problem, 5, seed=2)
    fits = multistart(problem, starts, threads=threads)
    for each, start in zip(fits, starts, strict=True):
        np.testing.assert_array_equal(each.start, start)
        np.testing.assert_array_equal(each.values, fit(problem, start).values)


def test_dask_finds_the_same(problem: GrayBoxProblem) -> None:
    with connected(threads=2) as client:
        there = multistart(problem, 4, seed=2, client=client)
    for remote, local in zip(there, multistart(problem, 4, seed=2), strict=True):
        np.testing.assert_array_equal(remote.values, local.values)


def test_progress_counts_the_fits(problem: GrayBoxProblem) -> None:
    counted: list[int] = []
    multistart(problem, 3, seed=0, progress=counted.append)
    assert counted == [1, 2, 3]


def test_wrong_start_ends_all(problem: GrayBoxProblem) -> None:
    with pytest.raises(InputError, match=r"start of body_1.ry.stiffness is 1e\+09"):
        multistart(problem, np.array([problem.scale.nominal, problem.scale.nominal * 1e4]))


def test_best_is_the_one_of_lowest_cost(problem: GrayBoxProblem) -> None:
    fits = multistart(problem, 5, seed=2)
    lowest = min(each.cost for each in fits)
    failed = replace(fits[0], cost=np.nan, converged=False)
    assert best(fits).cost == lowest
    assert best([failed, *fits]).cost == lowest
    assert best([*fits, replace(failed, cost=-np.inf)]).cost == lowest


def test_best_of_fits_that_all_failed_is_refused(problem: GrayBoxProblem) -> None:
    failed = replace(fit(problem), cost=np.nan, converged=False, message="the model cannot be evaluated")
    with pytest.raises(RunError, match=r"all 2 fits failed, .*: the model cannot be evaluated; give other starts"):
        best([failed, failed])


def test_best_of_none_is_refused() -> None:
    with pytest.raises(InputError, match=r"no fit was given to choose the best from"):
        best(())


def test_no_start_is_refused(problem: GrayBoxProblem) -> None:
    with pytest.raises(InputError, match=r"0 random starts .* allowed is 1 or more"):
        multistart(problem, 0)
