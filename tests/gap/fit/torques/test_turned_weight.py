"""Encoders with another zero, and a base at a slant, by the torques of a log."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from flexros.effects import PlacedEffect, RobotWithEffects
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.fit.torques.solution import TorqueRegression
from flexros.gap.fit.torques.turned_weight import with_turned_weight
from flexros.gap.settings import TorqueStartSettings
from tests.gap.rigid_arm import arm, record_of_arm
from tests.gap.turning_arm import COULOMB, VISCOUS, log_of, turning_arm

SETTINGS = TorqueStartSettings()


def zeros_of(*offsets: float, rough: bool = False, load: float = 0.0) -> TorqueRegression | None:
    record = record_of_arm(imported=True, load=load)
    record = replace(record, position=record.position + np.array(offsets))
    regress = partial(regress_torque, record, RobotWithEffects(arm(), ()), tolerance_of(arm(), {}), settings=SETTINGS)
    without = regress()
    assert without is not None
    return with_turned_weight(regress, without, arm(), record, SETTINGS, rough=rough)


@pytest.mark.parametrize("offsets", [(0.05, 0.0), (0.0, -0.08), (0.04, 0.06), (0.3, 0.0)])
def test_offsets_are_found_at_their_motors(offsets: tuple[float, float]) -> None:
    found = zeros_of(*offsets)
    assert found is not None
    assert set(found.zeros) == {motor for motor, offset in enumerate(offsets) if offset}
    for motor, offset in found.zeros.items():
        assert offset == pytest.approx(offsets[motor], abs=0.004)


def test_an_encoder_that_is_right_and_a_load_have_none() -> None:
    assert zeros_of(0.0, 0.0) is None
    assert zeros_of(0.0, 0.0, load=0.3) is None


def test_beside_rough_bodies_an_offset_must_explain_far_more() -> None:
    small = (0.0, 0.004)
    assert zeros_of(*small) is not None
    assert zeros_of(*small, rough=True) is None


def turned(tilt: tuple[float, float], *offsets: float, friction_known: bool = False) -> TorqueRegression | None:
    """Return what the torques of the arm that moves in space ask for, by rotations of its base and encoder offsets."""
    record, robot = log_of(tilt=np.array(tilt)), turning_arm()
    record = replace(record, position=record.position + np.array(offsets))
    model = RobotWithEffects(robot, ())
    if friction_known:
        viscous = {f"motor_{k}.viscous_friction": float(value) for k, value in enumerate(VISCOUS, start=1)}
        levels = [PlacedEffect(CoulombFriction(level=one), f"motor_{k}") for k, one in enumerate(COULOMB, start=1)]
        model = RobotWithEffects(robot.with_values(viscous), ()).with_effects(levels)
    regress = partial(regress_torque, record, model, tolerance_of(robot, {}), settings=SETTINGS)
    without = regress()
    assert without is not None
    return with_turned_weight(regress, without, robot, record, SETTINGS)


@pytest.mark.parametrize(
    ("tilt", "offsets", "zeros"),
    [
        ((0.02, -0.05), (0.0, 0.0, 0.0), set()),
        ((0.0, 0.1), (0.0, 0.0, 0.0), set()),
        ((0.02, -0.05), (0.0, 0.0, 0.06), {2}),
        ((0.0, 0.0), (0.0, 0.05, 0.0), {1}),
        ((0.0, 0.0), (0.0, -0.03, 0.05), {1, 2}),
    ],
)
def test_a_slant_of_the_base_and_encoder_offsets_do_not_stand_for_each_other(
    tilt: tuple[float, float], offsets: tuple[float, float, float], zeros: set[int]
) -> None:
    found = turned(tilt, *offsets)
    assert found is not None
    assert set(found.zeros) == zeros
    assert set(found.tilt) == (set("xy") if any(tilt) else set())
    for axis, angle in found.tilt.items():
        assert angle == pytest.approx(tilt["xy".index(axis)], abs=0.003)
    for motor, offset in found.zeros.items():
        assert offset == pytest.approx(offsets[motor], abs=0.006)


def test_a_slant_is_all_that_an_identified_model_lacks() -> None:
    found = turned((0.02, -0.05), 0.0, 0.0, 0.0, friction_known=True)
    assert found is not None
    assert not found.zeros
    assert found.tilt == pytest.approx({"x": 0.02, "y": -0.05}, abs=0.001)


def test_an_upright_base_whose_encoders_are_right_is_not_turned() -> None:
    assert turned((0.0, 0.0), 0.0, 0.0, 0.0) is None
