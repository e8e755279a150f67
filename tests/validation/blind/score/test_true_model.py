"""The truth of a case as a model of the library."""

from __future__ import annotations

import math

import pytest

from flexros.effects import RobotWithEffects
from flexros.validation.blind.deviation import Deviation
from flexros.validation.blind.draw.case_robots import case_robot
from flexros.validation.blind.draw.locations import places_of
from flexros.validation.blind.plant.laws import LIBRARY_LAWS
from flexros.validation.blind.score.true_model import library_effects, true_model
from tests.validation.blind.cases import truth


def model_of(effect: str, location: str, robot: str = "e12", **numbers: float) -> RobotWithEffects:
    hidden = truth("crowd", robot=robot).model_copy(
        update={"deviations": (Deviation(effect=effect, location=location, parameters=numbers),)}
    )
    return true_model(hidden)


def test_friction_that_drifts_is_converted_from_its_change_within_the_log() -> None:
    (law,) = model_of("friction_drift", "motor_1", coulomb=2.0, viscous=1.0, time_constant=10.0, duration=20.0).laws
    assert law.effect.parameter_values["coulomb"] == pytest.approx(2.0 / (1 - math.exp(-2.0)))


def test_asymmetry_of_viscous_friction_is_converted_to_that_of_the_whole() -> None:
    from flexros.robot import load_robot

    nominal = load_robot("six_axis").parameters["motor_1.viscous_friction"].value
    assert nominal > 0
    (law,) = model_of("viscous_friction", "motor_1", "six_axis", coefficient=3 * nominal, asymmetry=0.4).laws
    assert law.effect.parameter_values["asymmetry"] == pytest.approx(0.3)


def test_numbers_of_the_model_change_the_robot() -> None:
    from flexros.robot import load_robot

    robot = model_of("payload_error", "tool", robot="elbow", relative=0.1).robot
    name = f"body_{len(robot.spec.bodies)}.mass"
    assert robot.parameters[name].value == pytest.approx(1.1 * load_robot("elbow").parameters[name].value)


def test_causes_outside_the_library_are_left_out() -> None:
    assert not model_of("cable", "motor_1", torque=1.0, angle=0.1, length=0.1).laws


@pytest.mark.parametrize("robot", ["four_mass_linear", "four_mass", "elbow", "e12", "six_axis", "rigid_six_axis"])
def test_what_is_hidden_is_of_the_library_where_the_library_has_it(robot: str) -> None:
    """All places that are drawn, but the base of a robot whose first direction is rigid."""
    places = [(effect, place) for effect in LIBRARY_LAWS for place in places_of(effect, case_robot(robot))]
    hidden = tuple(Deviation(effect=effect, location=place, parameters={}) for effect, place in places)
    known = library_effects(truth("crowd", robot=robot).model_copy(update={"deviations": hidden}))
    outside = [("extra_mode", "base")] if robot == "rigid_six_axis" else []
    assert [(one.effect, one.location) for one in hidden if one not in known] == outside
