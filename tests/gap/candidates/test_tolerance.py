"""Numbers of the robot that may deviate: as its file says, or by kind."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of, with_torque_tolerance
from flexros.gap.settings import DiagnosisSettings
from flexros.robot import load_robot, robot_from_data


def test_exact_numbers_are_left_out() -> None:
    assert tolerance_of(load_robot("four_mass_linear"), {}).names == ()


def test_kinds_replace_what_the_file_says() -> None:
    found = tolerance_of(load_robot("four_mass_linear"), {"stiffness": 0.05})
    assert found.names == ("body_1.rz.stiffness", "body_2.rz.stiffness", "body_3.rz.stiffness")
    assert found.deviations == (0.05, 0.05, 0.05)


def test_tolerances_of_the_file_count() -> None:
    data = load_robot("four_mass_linear").spec.model_dump()
    data["bodies"][1]["directions"]["rz"]["spring"]["stiffness"]["tolerance"] = 0.1
    robot = robot_from_data(data, "test")
    assert tolerance_of(robot, {}).names == ("body_2.rz.stiffness",)
    assert tolerance_of(robot, {"stiffness": 0.0}).names == ()


def test_inertia_is_that_of_motors_and_bodies_but_not_zero_ones() -> None:
    robot = load_robot("elbow")
    names = tolerance_of(robot, {"inertia": 0.02}).names
    assert "motor_1.inertia" in names
    assert any(name.endswith(".mass") for name in names)
    assert all(robot.parameters[name].value != 0 for name in names)


def test_the_inertia_of_a_motor_of_prescribed_motion_is_no_number_of_the_robot() -> None:
    robot = load_robot("elbow")
    stated = tolerance_of(robot, {"inertia": 0.02})
    left = set(stated.names) - set(tolerance_of(robot, {"inertia": 0.02}, (1,)).names)
    assert left == {"motor_2.inertia"}


def test_a_stiffness_of_any_size_has_its_tolerance() -> None:
    """One motor of prescribed motion has an inertia of 1e9: a spring of 1e9 is none."""
    robot = load_robot("four_mass_linear").with_values({"body_2.rz.stiffness": 1e9})
    assert "body_2.rz.stiffness" in tolerance_of(robot, {"stiffness": 0.05}).names


def test_unknown_kinds_are_named() -> None:
    with pytest.raises(InputError, match="kind of tolerance.*stifness.*stiffness"):
        tolerance_of(load_robot("four_mass_linear"), {"stifness": 0.05})


def test_directions_in_which_a_log_does_not_inform_are_left_out() -> None:
    whole = Tolerance(("a", "b", "c"), (0.1, 0.1, 0.2))
    seen = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    few = whole.informed(100.0 * np.outer(seen, seen))
    assert few.n_free == 1
    np.testing.assert_allclose(few.by_name(few.along(np.array([2.0, 2.0, 5.0]))), [2.0, 2.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(few.logarithms(few.along(np.array([1.0, 1.0, 0.0]))), [0.1, 0.1, 0.0], atol=1e-12)


def test_a_number_that_only_shows_with_another_is_known_no_better_than_that_one() -> None:
    """A log shows the sum of the inertias of a rotor and of a body; the body is known to 0.03 x 0.2 kg m2."""
    rotor, body, of_rotor, of_body = 0.5, 0.2, 1.0, 0.03
    seen = np.array([rotor * of_rotor, body * of_body])
    few = Tolerance(("rotor", "body"), (of_rotor, of_body)).informed(1e4 * np.outer(seen, seen))
    covariance = np.linalg.inv(few.directions.T @ (1e4 * np.outer(seen, seen) + np.eye(2)) @ few.directions)
    deviation = rotor * np.hypot(few.fitted(covariance), few.uninformed)[0]
    assert deviation == pytest.approx(np.hypot(body * of_body, 0.01), rel=0.01)
    np.testing.assert_array_equal(Tolerance(("a",), (0.1,)).uninformed, [0.0])


def test_replaced_parameters_are_nominal() -> None:
    whole = Tolerance(("a", "b"), (0.1, 0.1))
    free = np.array([1.0, 2.0])
    assert whole.without(free, np.array([False, True])).tolist() == [1.0, 0.0]
    assert whole.without(free, np.array([False, False])) is free


def test_numbers_that_are_known_stay_nominal() -> None:
    whole = Tolerance(("a", "b"), (0.1, 0.2))
    assert whole.known({"b", "c"}).logarithms(np.array([1.0, 5.0])).tolist() == [0.1, 0.0]
    assert whole.known({"c"}) is whole


@pytest.mark.parametrize("n_free", [0, 1, 2])
def test_directions_that_are_left_out_are_all_others(n_free: int) -> None:
    some = Tolerance(("a", "b", "c"), (0.1, 0.1, 0.1), directions=np.eye(3)[:, :n_free])
    assert some.left_out.shape == (3, 3 - n_free)
    every = np.column_stack([some.directions, some.left_out])
    np.testing.assert_allclose(every.T @ every, np.eye(3), atol=1e-12)
    assert Tolerance(("a",), (0.1,)).left_out.shape == (1, 0)


def test_a_stated_tolerance_of_torques_is_one_of_the_log() -> None:
    settings = with_torque_tolerance(DiagnosisSettings(), {"torque": 0.005, "stiffness": 0.1})
    assert settings.noise.signal_tolerance == 0.005
    assert with_torque_tolerance(settings, {"stiffness": 0.1}) is settings
    robot = load_robot("e12")
    assert tolerance_of(robot, {"torque": 0.005}) == tolerance_of(robot, {})
