"""How effects are found, written and placed."""

from __future__ import annotations

import pytest

from flexros.effects import effects, parse_effect, plant_values
from flexros.errors import InputError
from flexros.robot import load_robot, robot_names


@pytest.mark.parametrize("robot_name", robot_names())
@pytest.mark.parametrize("name", sorted(effects()))
def test_neutral_value_changes_nothing(name: str, robot_name: str) -> None:
    robot = load_robot(robot_name)
    effect = effects()[name]()
    known = {**{key: p.value for key, p in robot.parameters.items()}, "delay": robot.delay}
    for location in effect.locations(robot):
        for key, value in effect.values(robot, location).items():
            assert value == known[key]


@pytest.mark.parametrize("name", sorted(effects()))
def test_every_parameter_states_its_unit(name: str) -> None:
    for field in effects()[name].model_fields.values():
        assert field.description
        assert "[" in field.description


def test_effect_as_written_on_the_command_line() -> None:
    placed = parse_effect("stiffness_error@body_2.ry:relative=-0.2", "--effect")
    values = plant_values(load_robot("e12"), [placed])
    assert values == {"body_2.ry.stiffness": pytest.approx(0.8e5)}


def test_payload_error_scales_mass_and_inertia_of_the_last_body() -> None:
    values = plant_values(load_robot("e12"), [parse_effect("payload_error@tool:relative=0.05", "--effect")])
    assert values["body_3.mass"] == pytest.approx(210)
    assert values["body_3.inertia.yy"] == pytest.approx(52.5)
    assert "body_2.mass" not in values


def test_motor_inertia_and_damping() -> None:
    placed = [
        parse_effect("motor_inertia_error@motor_2:relative=0.1", "--effect"),
        parse_effect("damping_error@body_3.ry:relative=0.5", "--effect"),
    ]
    assert plant_values(load_robot("e12"), placed) == pytest.approx({"motor_2.inertia": 110, "body_3.ry.damping": 75})


def test_effects_on_one_number_act_one_after_the_other() -> None:
    placed = [parse_effect("delay@all:time=0.0003", "--effect")] * 2
    assert plant_values(load_robot("four_mass"), placed) == pytest.approx({"delay": 0.0011})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("payload_error", "must be NAME@LOCATION"),
        ("payload_error@tool", "no parameter is given, so it would do nothing"),
        ("payload@tool:relative=1", "unknown effect 'payload' in --effect: did you mean 'payload_error'"),
        ("payload_error@tool:mass=1", "unknown key 'mass'.*allowed are relative"),
        ("payload_error@tool:relative=nan", "finite number"),
        ("payload_error@tool:relative=-2", "greater than -1"),
        (
            "payload_error@tool:relative=0.1,relative=0.2",
            r"^--effect payload_error: parameter 'relative' is given twice, as 0\.1 and 0\.2; remove one of them$",
        ),
    ],
)
def test_wrong_effect_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_effect(text, "--effect")


def test_wrong_location_is_refused() -> None:
    placed = parse_effect("stiffness_error@body_9.ry:relative=0.1", "--effect")
    with pytest.raises(InputError, match="unknown location of stiffness_error on robot e12 'body_9.ry'"):
        plant_values(load_robot("e12"), [placed])
