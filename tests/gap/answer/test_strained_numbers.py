"""Numbers of the model beyond their tolerance, as part of a repair."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.gap.answer.strained_numbers import STRAINED, STRAINED_ALONE, as_effects, far_out, moved_words
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.limits import numbers_at_limits
from flexros.robot import load_robot

FACTORS = {
    "body_7.mass": 0.7,
    "motor_2.inertia": 1.3,
    "body_2.rz.stiffness": 1.2,
    "body_3.center_of_mass.x": 0.8,
    "motor_1.viscous_friction": 1.5,
    "body_2.length.z": 1.02,
}


def test_a_repair_adds_what_numbers_and_effects_change_as_a_fit_does() -> None:
    robot = load_robot("six_axis")
    factors = {name: factor for name, factor in FACTORS.items() if robot.parameters[name].value != 0}
    assert len(factors) >= 4
    placed = [
        parse_effect("payload_error@tool:relative=-0.2", "test"),
        parse_effect("motor_inertia_error@motor_2:relative=0.5", "test"),
    ]
    repaired = place_effects(robot, (*placed, *as_effects(robot, placed, factors)))
    alone = place_effects(robot, placed).robot.parameters
    for name, factor in factors.items():
        nominal, now = robot.parameters[name].value, repaired.robot.parameters[name].value
        changed = alone[name].value + (factor - 1) * nominal
        if name == "motor_1.viscous_friction":  # a law adds to that of the robot file
            (law,) = (one for one in repaired.laws if one.effect.name == "viscous_friction")
            now += law.effect.parameter_values["coefficient"]
        assert now == pytest.approx(nominal if "length" in name else changed, rel=1e-12)


def test_numbers_of_no_possible_body_are_left_out() -> None:
    robot = load_robot("six_axis")
    heavy = parse_effect("payload_error@tool:relative=-0.9", "test")
    assert as_effects(robot, [heavy], {"body_7.mass": 0.05}) == ()


@pytest.mark.parametrize(("factor", "stated"), [(18.3, 1), (2000.0, 0)])
def test_a_damper_may_be_many_times_its_value_and_one_beyond_all_sizes_is_left_out(factor: float, stated: int) -> None:
    """A damper of an arm of six elastic axes was 18 times its value: an internal error, at the end of ten minutes."""
    assert len(as_effects(load_robot("elbow"), [], {"body_1.ry.damping": factor})) == stated


@pytest.mark.parametrize(("tolerance", "deviation", "far"), [
    (0.3, -2.87, True), (0.3, -1.9, False), (0.05, 3.9, False), (0.05, -4.1, True), (0.1, 3.5, False),
    (0.0, 9.0, False),
])  # fmt: skip
def test_a_guessed_number_is_far_out_where_its_factor_is_large(tolerance: float, deviation: float, far: bool) -> None:
    """An inertia that is tolerated by 30 % became 0.42 times its value, and nothing said so."""
    predictor = SimpleNamespace(tolerance=Tolerance(("motor_1.inertia",), (tolerance,)))
    fit: Any = SimpleNamespace(predictor=predictor, deviations=np.array([deviation]))
    found = far_out(fit, STRAINED)
    assert found == ({"motor_1.inertia": pytest.approx(np.exp(tolerance * deviation))} if far else {})
    if far:
        assert f"motor_1.inertia {'to 0.423 times, by' if tolerance > 0.1 else 'by -18.5 %,'}" in moved_words(
            fit, found
        )


@pytest.mark.parametrize(("deviation", "far"), [(5.9, False), (8.2, True)])
def test_the_damping_of_a_spring_is_far_out_by_its_tolerance_alone(deviation: float, far: bool) -> None:
    """Those of a right model of three elastic axes were 3 to 6 times their values, and asked to be corrected."""
    predictor = SimpleNamespace(tolerance=Tolerance(("body_3.ry.damping",), (0.3,)))
    fit: Any = SimpleNamespace(predictor=predictor, deviations=np.array([deviation]))
    assert bool(far_out(fit, STRAINED_ALONE)) is far


@pytest.mark.parametrize("factor", [1.929, 0.604, 3.2, 0.42])
def test_the_multiple_of_a_tolerance_is_that_of_the_change_that_is_stated(factor: float) -> None:
    """A friction by +92.9 % had been 6.6 times its tolerance, which is 10 %: a reader divides."""
    fit: Any = SimpleNamespace(predictor=SimpleNamespace(tolerance=Tolerance(("motor_1.inertia",), (0.1,))))
    figures = [float(one) for one in re.findall(r" [+-]?(\d[\d.]*)", moved_words(fit, {"motor_1.inertia": factor}))]
    change = figures[0] / 100 if 0.5 < factor < 2 else abs(figures[0] - 1)
    assert change == pytest.approx(abs(factor - 1), rel=0.01)
    assert figures[1:] == [pytest.approx(change / 0.1, rel=0.05), 10]


def test_a_large_factor_within_many_tolerances_is_not_far_out_where_only_tolerances_count() -> None:
    predictor = SimpleNamespace(tolerance=Tolerance(("motor_1.inertia",), (0.3,)))
    fit: Any = SimpleNamespace(predictor=predictor, deviations=np.array([-2.87]))
    assert not far_out(fit, STRAINED, large=False)


def test_a_number_is_at_the_limit_of_its_search_where_most_of_its_change_is() -> None:
    """A rotor was said to be 28 % heavier to six digits, where five tolerances were as far as was searched."""
    names, tolerances = ("motor_1.inertia", "body_1.mass", "body_2.mass"), (0.05, 0.05, 0.05)
    directions = np.array([[1.0, 0.0], [0.3, 0.9], [0.0, 1.0]])
    predictor = SimpleNamespace(tolerance=Tolerance(names, tolerances, directions=directions))
    fit: Any = SimpleNamespace(predictor=predictor, deviations=np.array([-5.0, 2.0]))
    assert numbers_at_limits(fit) == {"motor_1.inertia", "body_1.mass"}
    fit.deviations = np.array([-4.0, 2.0])
    assert numbers_at_limits(fit) == frozenset()
