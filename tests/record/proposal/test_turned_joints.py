"""A joint that counts the other way round, in logs of a rigid arm with friction and rotors that the model lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.proposal.propose import propose_mapping
from flexros.record.proposal.turned_joints import turned_joints
from flexros.record.record import Record
from tests.gap.rigid_arm import T, arm, motion, record_of_arm

ALONE = {(-1, 1): (0,), (1, -1): (1,)}


def turned(record: Record, signs: FloatArray | list[int], torque: FloatArray | list[int] | None = None) -> Record:
    return replace(
        record, position=signs * record.position, torque=(signs if torque is None else torque) * record.torque
    )


@pytest.mark.parametrize("signs", [(-1, 1), (1, -1)])
@pytest.mark.parametrize("torque", [1, -1])
def test_the_joint_is_found_whatever_the_sign_of_the_torques(signs: tuple[int, int], torque: int) -> None:
    record = turned(record_of_arm(), np.array(signs), torque * np.array(signs))
    found = turned_joints(record, arm())
    assert found is not None
    assert found.motors == ALONE[signs]
    assert found.after < 0.3 * found.before


@pytest.mark.parametrize("torque", [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_right_signs_of_the_positions_stay(torque: tuple[int, int]) -> None:
    assert turned_joints(turned(record_of_arm(), [1, 1], np.array(torque)), arm()) is None


def test_a_load_and_a_counterbalance_that_the_model_lacks_turn_nothing() -> None:
    assert turned_joints(record_of_arm(load=1.0, balance=(5.0, 20.0)), arm()) is None


@pytest.mark.parametrize(("joint", "angle"), [(0, 90), (0, -90), (1, 90), (1, -90), (1, 180)])
def test_a_zero_elsewhere_turns_nothing(joint: int, angle: float) -> None:
    record = record_of_arm()
    zero = np.radians(angle) * np.eye(2)[joint]
    assert turned_joints(replace(record, position=record.position + zero), arm()) is None


def test_without_weight_a_mirrored_arm_fits_as_well() -> None:
    """Of two parallel joints the log shows that one is turned, and not which."""
    light = arm().with_values(WEIGHTLESS)
    record = record_of_arm()
    record = replace(record, torque=rigid_inverse_dynamics(light, record.position, T, 20.0))
    found = turned_joints(turned(record, [1, -1]), light)
    assert found is not None
    assert (found.motors, found.alike) == ((0,), ((1,),))


def test_noise_turns_nothing() -> None:
    noise = np.random.default_rng(4).standard_normal(record_of_arm().torque.shape)
    assert turned_joints(replace(record_of_arm(), torque=noise), arm()) is None


@pytest.fixture
def table(tmp_path: Path) -> Callable[[list[int]], Path]:
    def write(signs: list[int]) -> Path:
        record, speed = record_of_arm(), motion()[1]
        columns = np.hstack([signs * one for one in (record.position, speed, record.torque)])
        rows = np.column_stack([T * np.arange(len(columns)), columns])
        np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header="t,q1,q2,dq1,dq2,tau1,tau2", comments="")
        return tmp_path / "run.csv"

    return write


def test_the_mapping_turns_position_velocity_and_torque(table: Callable[[list[int]], Path]) -> None:
    found = propose_mapping(table([1, -1]), arm())
    assert {(one.quantity, one.joint) for one in found.mapping.columns if one.sign < 0} == {
        (quantity, "motor_2") for quantity in ("position", "velocity", "measured_torque")
    }
    np.testing.assert_allclose(found.log.joint_states.position, record_of_arm().position, atol=1e-9)
    (signs,) = (one for one in found.assumptions if one.about == "signs")
    assert signs.taken.startswith("2 with the opposite sign")
    assert "of the torques unexplained instead of" in signs.ground


def test_the_mapping_of_right_signs_has_none(table: Callable[[list[int]], Path]) -> None:
    found = propose_mapping(table([1, 1]), arm())
    assert all(one.sign > 0 for one in found.mapping.columns)


def test_the_mapping_of_positions_that_begin_again_has_their_range(table: Callable[[list[int]], Path]) -> None:
    path = table([1, 1])
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    rows[:, 1] = (rows[:, 1] + 0.2 * rows[:, 0] + 0.3) % 1.5
    np.savetxt(path, rows, delimiter=",", header="t,q1,q2,dq1,dq2,tau1,tau2", comments="")
    found = propose_mapping(path, arm())
    assert [one.period for one in found.mapping.columns if one.quantity == "position"] == [1.5, None]
    (position,) = (one for one in found.assumptions if one.about == "position")
    assert "beginning again after 1.5 at motor_1" in position.taken
    assert np.abs(np.diff(found.log.joint_states.position, axis=0)).max() < 0.1
