"""Friction of a simulator in a robot file: it counts as none where torques do not show it, and can be stepped else."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.base import PlacedEffect
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.unknown_numbers import STEPS, UnknownNumbers, unknown_numbers
from flexros.gap.measure_gap import measure_gap
from flexros.gap.settings import DiagnosisSettings
from flexros.prediction.integration_step import stops_too_fast
from flexros.record.record import Record
from flexros.robot import Robot
from tests.gap.rigid_arm import COULOMB, INERTIA, VISCOUS, T, arm, motion, record_of_arm

FILE = 500.0
"""Viscous friction of the robot file; that of the log is `VISCOUS`."""
MOTORS = ("motor_1", "motor_2")


@cache
def damped() -> Robot:
    return arm().with_values({f"{name}.viscous_friction": FILE for name in MOTORS})


def damped_record() -> Record:
    """The log of an arm that has the friction of the file."""
    record, speed = record_of_arm(imported=True), motion()[1]
    held = 0.5 * (speed + np.vstack([speed[1:], speed[-1:]]))
    return replace(record, torque=record.torque + (FILE - VISCOUS) * held)


def unknown(record: Record) -> UnknownNumbers:
    return unknown_numbers(record, RobotWithEffects(damped(), ()), Tolerance())


def test_friction_that_torques_do_not_show_stands_for_none() -> None:
    found = unknown(record_of_arm(imported=True))
    assert found.placeholders == {"motor_1": FILE, "motor_2": FILE}
    np.testing.assert_allclose(list(found.inertias.values()), INERTIA, rtol=0.03)
    given = found.given_to(RobotWithEffects(damped(), ())).robot
    assert [given.parameters[f"{name}.viscous_friction"].value for name in MOTORS] == [0.0, 0.0]
    assert "at motor_1 (500), motor_2 (500) is that of a simulator" in found.warnings[0]
    assert not unknown_numbers(record_of_arm(imported=True), RobotWithEffects(arm(), ()), Tolerance()).warnings


def test_a_patched_model_lacks_no_friction() -> None:
    found = unknown(record_of_arm(imported=True))
    law = PlacedEffect(ViscousFriction(coefficient=-400.0), "motor_1")
    assert set(found.lacked_by(RobotWithEffects(damped(), ()).with_effects([law])).placeholders) == {"motor_2"}


def test_friction_that_torques_show_stays_and_can_be_stepped() -> None:
    assert stops_too_fast(damped(), T, STEPS)
    found = unknown(damped_record())
    assert not found.placeholders
    given = found.given_to(RobotWithEffects(damped(), ())).robot
    assert given.parameters["motor_1.viscous_friction"].value == FILE
    assert not stops_too_fast(given, T, STEPS)


@pytest.mark.slow
def test_the_patch_states_the_friction_of_the_log_against_that_of_the_file() -> None:
    settings = DiagnosisSettings(where=None, next_experiment=None)
    held = record_of_arm(imported=True, seed=6)
    result = diagnose(record_of_arm(imported=True), damped(), holdout=held, settings=settings)
    friction = {one.location: one.effect for one in result.patch if isinstance(one.effect, ViscousFriction)}
    sizes = [getattr(friction[name], "coefficient", np.nan) for name in MOTORS]
    np.testing.assert_allclose(sizes, VISCOUS - FILE, atol=0.3)
    levels = [one.effect.level for one in result.patch if one.effect.name == "coulomb_friction"]  # type: ignore[attr-defined]
    np.testing.assert_allclose(levels, COULOMB, rtol=0.05)
    assert len(result.patch) == 6
    assert any("is that of a simulator" in text for text in result.diagnosis.warnings)
    repaired = RobotWithEffects(damped(), ()).with_effects(result.patch)
    gap = measure_gap(held, RobotWithEffects(damped(), ()), repaired=repaired, settings=settings).numbers
    assert gap.closed_fraction is not None
    assert gap.closed_fraction > 0.95
