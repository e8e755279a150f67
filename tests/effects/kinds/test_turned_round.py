"""Effects as joints have them that count the other way round."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.effects import effects
from flexros.effects.gear.spring_curve import _more
from flexros.effects.kinds.base import AbstractEffect
from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.motor_law import AbstractMotorTorque, MotorState
from flexros.effects.kinds.sensor import AbstractSensor

POSITION, SPEED, TORQUE = 0.37, -0.8, 1.3
VALUES = {"low": -0.9, "high": 0.6, "order": 3.0, "speed": 2.0}
"""Values of parameters that are no sizes."""


def uneven(name: str) -> AbstractEffect:
    """An effect with another value of each size."""
    kind = effects()[name]
    sizes = {key: 0.11 + 0.07 * place for place, key in enumerate(kind.ranges)}
    return kind(**{key: value for key, value in {**sizes, **VALUES}.items() if key in kind.model_fields})


def at(position: float, speed: float, torque: float) -> MotorState:
    return MotorState(ca.SX(position), ca.SX(2 * position), ca.SX(speed), ca.SX(torque), viscous_friction=0.4)


def of_kind(kind: type) -> list[str]:
    no_state = (name for name, each in effects().items() if issubclass(each, kind) and not each.smooth_states)
    return sorted(no_state)


def assert_opposite_at_the_opposite_motion(effect: AbstractEffect) -> None:
    """Compare its torque with that of the effect turned round, where the motor moves the other way."""
    opposite = effect.turned_round()
    here = effect.added(at(POSITION, SPEED, TORQUE), effect.parameter_values)
    there = opposite.added(at(-POSITION, -SPEED, -TORQUE), opposite.parameter_values)
    assert float(ca.DM(there)) == pytest.approx(-float(ca.DM(here)))


@pytest.mark.parametrize("name", of_kind(AbstractMotorTorque))
def test_torque_is_opposite_at_the_opposite_motion(name: str) -> None:
    assert_opposite_at_the_opposite_motion(uneven(name))


def test_a_proportional_ripple_is_that_of_the_opposite_torque() -> None:
    ripple = effects()["torque_ripple"](amplitude=0.2, phase=0.7, second_sine=0.3, second_cosine=0.1, proportional=True)
    assert_opposite_at_the_opposite_motion(ripple)


@pytest.mark.parametrize("name", of_kind(AbstractDryFriction))
def test_directions_of_dry_friction_are_exchanged(name: str) -> None:
    effect = uneven(name)
    opposite = effect.turned_round()
    here = effect.levels(at(POSITION, SPEED, TORQUE), effect.parameter_values)
    there = opposite.levels(at(-POSITION, -SPEED, -TORQUE), opposite.parameter_values)
    assert float(ca.DM(there.forward)) == pytest.approx(float(ca.DM(here.backward)))


@pytest.mark.parametrize("name", [name for name in of_kind(AbstractSensor) if name != "encoder_quantization"])
def test_error_of_a_sensor_is_opposite_at_the_opposite_position(name: str) -> None:
    effect = uneven(name)
    opposite = effect.turned_round()
    here = effect.read(ca.SX(POSITION), ca.SX(2 * POSITION), effect.parameter_values)
    there = opposite.read(ca.SX(-POSITION), ca.SX(-2 * POSITION), opposite.parameter_values)
    assert float(ca.DM(there)) == pytest.approx(-float(ca.DM(here)))


@pytest.mark.parametrize("deflection", np.linspace(-1.0, 0.8, 7))
def test_a_curve_of_a_spring_is_opposite_at_the_opposite_deflection(deflection: float) -> None:
    effect = uneven("spring_curve")
    opposite = effect.turned_round()
    here = _more(ca.SX(deflection), effect.parameter_values)
    there = _more(ca.SX(-deflection), opposite.parameter_values)
    assert float(ca.DM(there)) == pytest.approx(-float(ca.DM(here)))
