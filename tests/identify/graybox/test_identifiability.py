from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.identify.graybox.fit import fit
from flexros.identify.graybox.identifiability import identifiability
from flexros.identify.graybox.problem import graybox_problem

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot
    from tests.identify.graybox.conftest import Measure

    Responses = tuple[FrequencyResponse, ...]

PENDULUM = ["body_1.mass", "body_1.inertia.zz", "body_1.rz.stiffness"]


def test_parameters_that_the_responses_show_are_determined(
    e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "LLS", "optimal")
    verdict = identifiability(problem, fit(problem))
    assert verdict.names("determined") == tuple(e12_names)
    assert verdict.directions == ()
    assert verdict.parameters[0].unit == "Nm/rad"
    assert all(each.interval[0] < each.value < each.interval[1] for each in verdict.parameters)


def test_pair_that_cannot_be_distinguished_is_found_with_its_combination(pendulum: Robot, measured: Measure) -> None:
    responses = measured(pendulum, np.array([[0.0]]), np.linspace(2.0, 60.0, 40), noise=1e-3)
    problem = graybox_problem(pendulum, responses, PENDULUM)
    verdict = identifiability(problem, fit(problem, problem.scale.nominal * np.array([1.2, 0.9, 1.1])))
    assert verdict.names("not_determined") == ("body_1.mass", "body_1.inertia.zz")
    assert verdict.names("determined") == ("body_1.rz.stiffness",)
    (direction,) = verdict.directions
    shares = {each.name: each.value for each in verdict.parameters}
    ratio = shares["body_1.mass"] * 0.25 / shares["body_1.inertia.zz"]  # m x^2 / J
    moved, stays = dict(direction.exponents), dict(direction.determined)
    assert moved["body_1.inertia.zz"] / moved["body_1.mass"] == pytest.approx(-ratio, rel=0.02)
    assert stays["body_1.mass"] / stays["body_1.inertia.zz"] == pytest.approx(ratio, rel=0.02)
    assert direction.determined_deviation < 0.01


def test_combination_is_put_into_words(pendulum: Robot, measured: Measure) -> None:
    responses = measured(pendulum, np.array([[0.0]]), np.linspace(2.0, 60.0, 40), noise=1e-3)
    problem = graybox_problem(pendulum, responses, PENDULUM)
    (direction,) = identifiability(problem, fit(problem)).directions
    assert direction.sentence.startswith("body_1.inertia.zz x body_1.mass^0.5 is determined to 0.")
    assert "but not body_1.mass x body_1.inertia.zz^-0.5" in direction.sentence


def test_length_along_the_axis_of_rotation_does_not_act(e12: Robot, noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, ["body_1.ry.stiffness", "body_2.length.y"])
    verdict = identifiability(problem, fit(problem))
    assert verdict.names("not_determined") == ("body_2.length.y",)
    (direction,) = verdict.directions
    assert direction.sentence == (
        "body_2.length.y is not determined (standard deviation more than a factor of 1000): "
        "the responses hardly depend on it."
    )


def test_value_on_a_bound_is_not_determined(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "LLS", "optimal")
    result = fit(problem, problem.scale.nominal * 1.3, bounds={"body_3.ry.stiffness": (1.2e5, 2e5)})
    verdict = {each.name: each for each in identifiability(problem, result).parameters}["body_3.ry.stiffness"]
    assert verdict.verdict == "not_determined"
    assert verdict.reason.startswith("the fit ended on a bound; standard deviation")


def test_between_determined_and_not_is_weak(e12: Robot, e12_names: list[str], measured: Measure) -> None:
    responses = measured(e12, np.array([[0.0, 0.3]]), np.linspace(1.0, 40.0, 40), noise=0.15)
    problem = graybox_problem(e12, responses, e12_names, "NLS", "optimal")
    verdict = identifiability(problem, fit(problem))
    weak = [each for each in verdict.parameters if each.verdict == "weak"]
    assert weak
    assert all(0.10 < each.relative < 0.354 for each in weak)
