"""Making up for known effects: what reaches the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np
import pytest

from flexros.effects import PlacedLaw, parse_effect, place_effects
from flexros.feedforward.compensation.compensation import motor_delays
from flexros.feedforward.motion import Reference
from flexros.feedforward.reference import compute_reference, reference_chunks
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.feedforward.tool_geometry import ToolGeometry
from flexros.robot import Robot
from flexros.trajectory import Trajectory
from tests.feedforward.cases import edited_robot

pytestmark = pytest.mark.slow

DAE = FeedforwardSpecification()


def laws(robot: Robot, *texts: str) -> Sequence[PlacedLaw]:
    return place_effects(robot, [parse_effect(text, "test") for text in texts]).laws


def references(robot: Robot, path: Trajectory, *texts: str, method: str = "dae") -> tuple[Reference, Reference]:
    """Reference without and with known effects, 0.9 s at 1 ms."""
    settings = FeedforwardSpecification.model_validate({"method": method})
    plain, known = (
        compute_reference(robot, path, settings, 1e-3, 0.9, laws=given) for given in ((), laws(robot, *texts))
    )
    return plain, known


@pytest.mark.parametrize("chunk", [1, 170, 4096])
def test_chunks_equal_the_whole_bit_for_bit(e12: Robot, smooth: Trajectory, chunk: int) -> None:
    given = laws(e12, "hysteresis@motor_1:level=100", "coulomb_friction@motor_2:level=50", "delay@motor_1:time=0.0023")
    whole = compute_reference(e12, smooth, DAE, 1e-3, 0.2, laws=given)
    parts = Reference.concatenate(list(reference_chunks(e12, smooth, DAE, 1e-3, 0.2, chunk=chunk, laws=given)))
    assert all(np.array_equal(getattr(whole, field.name), getattr(parts, field.name)) for field in fields(Reference))


def test_effects_that_are_switched_off_change_nothing(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "coulomb_friction@motor_1:level=0", "backlash@motor_2:gap=0")
    assert all(np.array_equal(getattr(plain, field.name), getattr(known, field.name)) for field in fields(Reference))


def test_dry_friction_adds_its_level_in_the_direction_of_motion(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "coulomb_friction@motor_1:level=50,asymmetry=0.4")
    added = (known.torque - plain.torque)[:, 0]
    speed = plain.motor_velocity[:, 0]
    fast = np.abs(speed) > 0.02 * np.abs(speed).max()
    np.testing.assert_allclose(added[fast], np.where(speed > 0, 60.0, -40.0)[fast], rtol=1e-9)
    assert np.abs(added[np.abs(speed) < 1e-6 * np.abs(speed).max()]).max() < 1.0
    assert np.array_equal(known.motor_position, plain.motor_position)


def test_friction_under_load_adds_its_share_of_the_torque_of_the_gear(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "load_dependent_friction@motor_1:share=0.1")
    added, speed = (known.torque - plain.torque)[:, 0], plain.motor_velocity[:, 0]
    rotor = e12.parameters["motor_1.inertia"].value * np.gradient(speed, 1e-3)
    load = plain.torque[:, 0] - rotor - e12.parameters["motor_1.viscous_friction"].value * speed
    fast = np.abs(speed) > 0.02 * np.abs(speed).max()
    expected = 0.1 * np.abs(load) * np.sign(speed)
    np.testing.assert_allclose(added[fast], expected[fast], atol=0.02 * np.abs(expected).max())


def test_a_gain_divides_the_torque_and_a_bias_is_taken_away(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "torque_gain_error@motor_2:relative=0.25", "torque_bias@motor_2:level=30")
    np.testing.assert_allclose(known.torque[:, 1], (plain.torque[:, 1] - 30.0) / 1.25, rtol=1e-9)
    np.testing.assert_allclose(known.torque[:, 0], plain.torque[:, 0])


def test_a_delay_of_one_motor_gives_its_torque_ahead_of_time(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "delay@motor_2:time=0.003")
    np.testing.assert_allclose(known.torque[:-3, 1], plain.torque[3:, 1], atol=1e-9)
    np.testing.assert_allclose(known.torque[:, 0], plain.torque[:, 0])
    assert motor_delays(e12, laws(e12, "delay@motor_2:time=0.003")) == (0.0, 0.003)


def test_backlash_leads_the_motor_from_flank_to_flank(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "backlash@motor_1:gap=0.0004")
    shift = (known.motor_position - plain.motor_position)[:, 0]
    at_flank = np.isclose(np.abs(shift), 2e-4, atol=1e-6)
    assert at_flank.mean() > 0.8
    assert {-1.0, 1.0} == set(np.sign(shift[at_flank]))
    assert np.abs(np.diff(shift)).max() < 1e-4  # through the gap in several samples, not at once


def test_an_encoder_with_eccentricity_gets_the_reading_of_the_true_position(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "encoder_eccentricity@motor_1:amplitude=0.001,order=3,phase=0.2")
    wave = known.motor_position[:, 0] - plain.motor_position[:, 0]
    np.testing.assert_allclose(np.abs(wave), np.abs(1e-3 * np.sin(3 * plain.motor_position[:, 0] + 0.2)), atol=1e-12)
    rate = np.gradient(known.motor_position[:, 0], 1e-3)
    np.testing.assert_allclose(known.motor_velocity[5:-5, 0], rate[5:-5], atol=2e-3)


@pytest.mark.parametrize("method", ["rigid", "flexible_joint", "dae"])
def test_the_tool_goes_where_it_is_wanted_with_errors_of_the_kinematics(
    e12: Robot, smooth: Trajectory, method: str
) -> None:
    text = "kinematic_error@body_2:length=0.002,angle=0.001"
    plain, known = references(e12, smooth, text, method=method)
    assert np.abs(known.motor_position - plain.motor_position).max() > 1e-3
    np.testing.assert_allclose(known.tool_pose[:, :3], plain.tool_pose[:, :3], atol=1e-12)
    geometry = ToolGeometry.of(e12, laws(e12, text))
    assert geometry.robot.parameters["body_2.length.x"].value == pytest.approx(1.002)
    assert geometry.offsets == (0.0, 0.001, 0.0)


def test_without_feedforward_nothing_is_made_up_for(e12: Robot, smooth: Trajectory) -> None:
    plain, known = references(e12, smooth, "coulomb_friction@motor_1:level=50", method="none")
    assert np.array_equal(known.torque, plain.torque)


def test_hysteresis_starts_and_stays_unloaded_while_the_robot_rests(e12: Robot, smooth: Trajectory) -> None:
    rests = compute_reference(e12, smooth, DAE, 1e-3, 0.0, laws=laws(e12, "hysteresis@motor_1:level=100"))
    plain = compute_reference(e12, smooth, DAE, 1e-3, 0.0)
    np.testing.assert_allclose(rests.motor_position, plain.motor_position, atol=1e-9)


def test_gears_of_motors_that_also_act_on_the_arm_are_skipped(smooth: Trajectory) -> None:
    coupled = edited_robot("e12", lambda data: data.update(inertial_coupling=True))
    plain, known = references(coupled, smooth, "transmission_error@motor_1:amplitude=0.001")
    assert np.array_equal(known.motor_position, plain.motor_position)
