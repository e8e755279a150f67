"""Discovery, formatting and placement of effects."""

from __future__ import annotations

import pytest

from flexros.effects import PlacedEffect, effects, parse_effect, place_effects
from flexros.errors import InputError
from flexros.robot import load_robot, robot_names
from flexros.simulate.plant_model import PlantModel


def values_with(robot_name: str, *texts: str) -> dict[str, float]:
    """Place effects on a robot, and return the changed parameters."""
    before = load_robot(robot_name)
    after = place_effects(before, [parse_effect(text, "--effect") for text in texts]).robot
    values = {name: p.value for name, p in after.parameters.items() if p.value != before.parameters[name].value}
    return values | ({} if after.delay == before.delay else {"delay": after.delay})


@pytest.mark.slow
@pytest.mark.parametrize("robot_name", robot_names())
@pytest.mark.parametrize("name", sorted(effects()))
def test_neutral_value_changes_nothing(name: str, robot_name: str) -> None:
    robot = load_robot(robot_name)
    placed = [PlacedEffect(effects()[name](), location) for location in effects()[name]().locations(robot)]
    result = place_effects(robot, placed)
    assert result.robot.spec == robot.spec
    assert PlantModel(result.robot, result.laws).laws == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(effects()))
def test_effect_has_a_location_on_some_robot_and_survives_a_round_trip(name: str) -> None:
    places = [(load_robot(robot), effects()[name]().locations(load_robot(robot))) for robot in robot_names()]
    assert any(locations for _, locations in places)
    placed = PlacedEffect(effects()[name](), "here")
    assert parse_effect(str(placed), "--effect") == placed


@pytest.mark.parametrize("name", sorted(effects()))
def test_every_parameter_states_its_unit(name: str) -> None:
    for field in effects()[name].model_fields.values():
        assert field.description
        assert "[" in field.description


def test_effect_as_written_on_the_command_line() -> None:
    values = values_with("e12", "stiffness_error@body_2.ry:relative=-0.2")
    assert values == {"body_2.ry.stiffness": pytest.approx(0.8e5)}


def test_payload_error_scales_mass_and_inertia_of_the_last_body() -> None:
    values = values_with("e12", "payload_error@tool:relative=0.05")
    assert values["body_3.mass"] == pytest.approx(210)
    assert values["body_3.inertia.yy"] == pytest.approx(52.5)
    assert "body_2.mass" not in values


def test_motor_inertia_and_damping() -> None:
    values = values_with("e12", "motor_inertia_error@motor_2:relative=0.1", "damping_error@body_3.ry:relative=0.5")
    assert values == pytest.approx({"motor_2.inertia": 110, "body_3.ry.damping": 75})


def test_effects_on_one_parameter_act_in_sequence() -> None:
    assert values_with("four_mass", *["delay@all:time=0.0003"] * 2) == pytest.approx({"delay": 0.0011})


def test_equal_laws_get_distinct_names() -> None:
    placed = [parse_effect("torque_ripple@motor_1:amplitude=2", "--effect")] * 2
    names = [law.name for law in place_effects(load_robot("e12"), placed).laws]
    assert names == ["torque_ripple@motor_1", "torque_ripple@motor_1#2"]


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
        place_effects(load_robot("e12"), [placed])
