"""Friction that stops a light joint faster than predictions take steps."""

from __future__ import annotations

import pytest

from flexros.effects import PlacedEffect, RobotWithEffects
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.gap.prediction.braking import braked_robot, runaway_warning
from flexros.gap.prediction.compiled_plant import CompiledPlant
from flexros.prediction.integration_step import MOST
from tests.gap.rigid_arm import T, arm

LIGHT = arm().with_values({"body_2.mass": 0.05, "body_2.inertia.yy": 1e-4})


def _with_friction(coefficient: float, asymmetry: float = 0.0) -> RobotWithEffects:
    effect = ViscousFriction(coefficient=coefficient, asymmetry=asymmetry)
    return RobotWithEffects(LIGHT, ()).with_effects([PlacedEffect(effect, "motor_2")])


def test_friction_of_a_law_counts_in_the_direction_in_which_it_is_larger() -> None:
    robot = LIGHT.with_values({"motor_2.viscous_friction": 0.5})
    effect = ViscousFriction(coefficient=1.5, asymmetry=-0.4)
    model = RobotWithEffects(robot, ()).with_effects([PlacedEffect(effect, "motor_2")])
    parameters = braked_robot(model).parameters
    assert parameters["motor_2.viscous_friction"].value == pytest.approx(2.0 * 1.2)
    assert parameters["motor_1.viscous_friction"].value == LIGHT.parameters["motor_1.viscous_friction"].value


def test_a_plant_takes_steps_that_the_friction_of_known_laws_needs() -> None:
    calm, braked = (CompiledPlant(_with_friction(one), (), (), T).steps for one in (1e-3, 1.0))
    assert calm < braked < MOST
    assert not runaway_warning(_with_friction(1.0), T, braked)


def test_a_joint_that_no_steps_can_follow_is_named() -> None:
    model = _with_friction(1000.0)
    (text,) = runaway_warning(model, T, CompiledPlant(model, (), (), T).steps)
    assert "motor_2" in text
    assert "motor_1" not in text
