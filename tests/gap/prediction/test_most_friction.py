"""Viscous friction of laws and candidates, which decides about the steps of a prediction."""

from __future__ import annotations

import pytest

from flexros.effects import PlacedEffect, RobotWithEffects
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.prediction.compiled_plant import CompiledPlant
from flexros.gap.prediction.most_friction import LIKELY, most_friction
from tests.gap.rigid_arm import T, arm

LIGHT = arm().with_values({"body_2.mass": 0.05, "body_2.inertia.yy": 1e-4})


def _with_friction(coefficient: float, asymmetry: float = 0.0) -> RobotWithEffects:
    effect = ViscousFriction(coefficient=coefficient, asymmetry=asymmetry)
    return RobotWithEffects(LIGHT, ()).with_effects([PlacedEffect(effect, "motor_2")])


def _candidate(high: float) -> Candidate:
    free = FreeParameter("coefficient", 1e-6 * high, high, signed=False, starts=(0.1 * high,))
    return Candidate(ViscousFriction, "motor_2", (free,))


def test_friction_of_a_law_counts_in_the_direction_in_which_it_is_larger() -> None:
    assert most_friction(_with_friction(1.5, -0.4), ()) == pytest.approx((0.0, 1.5 * 1.2))


def test_a_candidate_counts_with_much_of_its_range() -> None:
    assert most_friction(_with_friction(1.5), [_candidate(4.0)]) == pytest.approx((0.0, 1.5 + LIKELY * 4.0))


def test_steps_are_implicit_where_friction_stops_a_light_joint_within_a_sample() -> None:
    assert not CompiledPlant(_with_friction(1e-3), (), (), T).steps.implicit
    assert CompiledPlant(_with_friction(10.0), (), (), T).steps.implicit
    assert not CompiledPlant(RobotWithEffects(LIGHT, ()), [_candidate(1e-3)], (), T).steps.implicit
    assert CompiledPlant(RobotWithEffects(LIGHT, ()), [_candidate(100.0)], (), T).steps.implicit
