"""Sizes of effects as multiples of what the encoders of a robot would just show."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import AbstractEffect, parse_effect, place_effects
from flexros.effects.kinds.floors import rigid_inertia
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.simulate.plant import Plant


def placed(robot_name: str, text: str) -> AbstractEffect:
    (law,) = place_effects(load_robot(robot_name), [parse_effect(text, "--effect")]).laws
    return law.effect


def test_floor_of_a_torque_moves_the_motor_by_the_noise_in_a_tenth_of_a_second() -> None:
    """A robot of one rigid mass, so that the motion is exactly that of the definition."""
    robot = load_robot("emps").with_values({"motor_1.viscous_friction": 0.0})
    result = place_effects(robot, [parse_effect("torque_bias@motor_1:level=3floors", "--effect")])
    plant = Plant(result.robot, 1e-3, np.zeros(2), laws=result.laws)
    for _ in range(100):
        plant.advance([0.0])
    assert plant.state[0] == pytest.approx(3 * robot.encoder_noise[0], rel=1e-9)


def test_floors_of_angle_and_speed_are_those_of_the_encoder() -> None:
    noise = load_robot("six_axis").encoder_noise[1]
    angle = placed("six_axis", "encoder_eccentricity@motor_2:amplitude=5floors,order=2")
    speed = placed("six_axis", "stribeck_friction@motor_2:extra=1,velocity=5floors")
    assert angle.model_dump() == {"amplitude": pytest.approx(5 * noise), "order": 2.0, "phase": 0.0}
    assert speed.model_dump(include={"extra", "velocity"}) == {"extra": 1.0, "velocity": pytest.approx(50 * noise)}


def test_inertia_is_that_of_motor_and_rigid_arm() -> None:
    parameters = load_robot("four_mass").parameters
    total = sum(parameters[name].value for name in ("motor_1.inertia", *(f"body_{k}.inertia.zz" for k in (1, 2, 3))))
    assert rigid_inertia(load_robot("four_mass")) == pytest.approx([total])


def test_floors_survive_being_written() -> None:
    given = parse_effect("coulomb_friction@motor_1:level=12floors,asymmetry=0.5", "--effect")
    assert str(given) == "coulomb_friction@motor_1:level=12.0floors,asymmetry=0.5"
    assert parse_effect(str(given), "--effect") == given


@pytest.mark.parametrize(
    "text", ["payload_error@tool:relative=3floors", "torque_ripple@motor_1:order=3floors", "delay@all:time=2floors"]
)
def test_quantity_without_floor_is_refused(text: str) -> None:
    with pytest.raises(
        InputError,
        match=r"parameter '\w+' is given in noise floors, but only torques, speeds, motor angles and deflections of "
        "gears have one; give it as a number",
    ):
        parse_effect(text, "--effect")


def test_encoder_without_noise_is_refused() -> None:
    data = load_robot("e12").spec
    sensors = data.sensors.model_copy(
        update={"encoder_noise": data.sensors.encoder_noise.model_copy(update={"value": 0.0})}
    )
    robot = type(load_robot("e12"))(data.model_copy(update={"sensors": sensors}), "test")
    with pytest.raises(InputError, match=r"the encoder of motor_1 of robot e12 has no noise; give it as a number"):
        place_effects(robot, [parse_effect("torque_bias@motor_1:level=3floors", "--effect")])


def test_floor_multiple_must_be_numeric() -> None:
    with pytest.raises(InputError, match=r"key 'level' is 'twelve', but"):
        parse_effect("coulomb_friction@motor_1:level=twelvefloors", "--effect")
