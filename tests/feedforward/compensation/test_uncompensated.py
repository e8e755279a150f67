"""Report of the effects that a feedforward does not compensate."""

from __future__ import annotations

import pytest

from flexros.effects import effects, parse_effect, place_effects
from flexros.feedforward.compensation.uncompensated import uncompensated
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import Robot, load_robot
from tests.feedforward.cases import edited_robot


def reported(robot: Robot, text: str, **settings: object) -> tuple[str, ...]:
    model = place_effects(robot, [parse_effect(text, "test")])
    return uncompensated(model.robot, model.laws, FeedforwardSpecification.model_validate(settings))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("torque_saturation@motor_1:limit=100", "no command exceeds a torque limit"),
        ("encoder_quantization@motor_2:step=1e-5", "the error of the encoder is not known in advance"),
        ("extra_mode@tool:ratio=0.1,frequency=20", "it has states of its own"),
    ],
)
def test_effect_and_reason_are_named(e12: Robot, text: str, reason: str) -> None:
    (sentence,) = reported(e12, text)
    assert text.split(":")[0] in sentence
    assert f"not compensated: {reason}" in sentence


def test_a_delay_needs_the_compensation_of_the_hold(e12: Robot) -> None:
    text = "delay@motor_1:time=0.001"
    assert reported(e12, text) == ()
    (sentence,) = reported(e12, text, order=1)
    assert sentence.endswith("set feedforward.hold_compensation to true")


def test_a_gear_of_a_motor_that_also_acts_on_the_arm_is_named() -> None:
    coupled = edited_robot("e12", lambda data: data.update(inertial_coupling=True))
    (sentence,) = reported(coupled, "transmission_error@motor_1:amplitude=0.001")
    assert "the motors act on the arm" in sentence


def test_nothing_is_reported_without_feedforward(e12: Robot) -> None:
    assert reported(e12, "extra_mode@tool:ratio=0.1", method="none") == ()


def test_switched_off_effects_are_not_named(e12: Robot) -> None:
    assert reported(e12, "extra_mode@tool:ratio=0") == ()


LEFT = {"torque_saturation", "encoder_quantization", "extra_mode", "servo_command_lag"}
"""Effects that no feedforward compensates; a new kind is either compensated or listed here."""


@pytest.mark.parametrize("name", sorted(effects()))
def test_every_effect_is_compensated_or_reported(name: str) -> None:
    kind = effects()[name]
    numbers = {
        "nonlinear_stiffness": "relative=0.1,knee=0.01",
        "presliding_friction": "level=1,stiffness=1e6",
        "torque_saturation": "limit=1",
        "base_tilt": "x=0.01",
        "body_difference": "mass=0.01",
        "center_error": "x=0.01",
        "rotor_inertia": "added=0.01",
        "tool_load": "mass=0.01",
    }.get(name, f"{getattr(kind, 'size', 'relative')}=0.01")
    effect = parse_effect(f"{name}@somewhere:{numbers}", "test").effect
    robot = next(robot for robot in map(load_robot, ("e12", "elbow", "emps_servo")) if effect.locations(robot))
    sentences = reported(robot, f"{name}@{effect.locations(robot)[0]}:{numbers}")
    assert bool(sentences) == (name in LEFT)
