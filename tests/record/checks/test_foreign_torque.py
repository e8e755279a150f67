"""Torques that have nothing to do with the motion of their joint are told from balanced and wrongly scaled ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.record.checks.foreign_torque import without_foreign_torque
from flexros.record.record import Record
from flexros.simulate.plant import Plant
from tests.gap.rigid_arm import arm, motion, record_of_arm


def with_torque(torque: FloatArray, *, imported: bool = True) -> Record:
    return replace(record_of_arm(imported=imported), torque=torque)


def wandering(size: float) -> FloatArray:
    """Return torques of which the second is noise with the spectrum of a slow drive [Nm]."""
    torque = record_of_arm(imported=True).torque.copy()
    noise = np.convolve(np.random.default_rng(1).standard_normal(len(torque)), np.ones(40) / np.sqrt(40), "same")
    torque[:, 1] = size * noise
    return torque


def test_the_motion_of_a_joint_with_a_foreign_torque_is_prescribed() -> None:
    record = without_foreign_torque(with_torque(wandering(0.2)), arm())
    assert record.prescribed == (1,)
    assert "the measured motion of motor_2 drives the model there" in record.warnings[-1]
    assert without_foreign_torque(record, arm()) is record


def test_torques_of_a_simulation_are_what_they_are() -> None:
    record = with_torque(wandering(0.2), imported=False)
    assert without_foreign_torque(record, arm()) is record


@pytest.mark.parametrize("case", ["true", "unit", "balanced", "nearly"])
def test_torques_that_belong_to_the_motion_count(case: str) -> None:
    """One in a wrong unit is a multiple of what the bodies need; where weight is balanced, friction is left."""
    torque, (position, speed, _) = record_of_arm(imported=True).torque.copy(), motion()[:, :, 1]
    torque[:, 1] = {
        "true": torque[:, 1],
        "unit": 0.1 * torque[:, 1],
        "balanced": 0.3 * np.sign(speed) + 0.02 * np.random.default_rng(1).standard_normal(len(speed)),
        "nearly": 0.1 * np.sign(speed) + 0.4 * np.cos(position),
    }[case]
    record = with_torque(torque)
    assert without_foreign_torque(record, arm()) is record


def test_a_log_keeps_its_torques_where_none_would_be_left() -> None:
    torque = wandering(0.2)
    torque[:, 0] = 5.0 * torque[:, 1]
    record = with_torque(torque)
    assert without_foreign_torque(record, arm()) is record


def test_damping_of_a_simulator_in_the_robot_file_makes_no_torque_foreign() -> None:
    """As 10 Nms/rad at each joint of a URDF: of that friction a torque is a small part, not of what the bodies need."""
    torque = wandering(1.0)
    own = record_of_arm(imported=True).torque[:, 1]
    torque[:, 1] = own + np.std(own) / np.std(torque[:, 1]) * torque[:, 1]
    record = with_torque(torque)
    assert without_foreign_torque(record, arm()) is record
    assert without_foreign_torque(record, arm().with_values({"motor_2.viscous_friction": 50.0})) is record


def test_a_link_that_swings_freely_needs_no_torque() -> None:
    """Its acceleration is that of its weight, also where the inertias of the robot file are four times too large."""
    robot, rng = arm(), np.random.default_rng(3)
    names = [f"body_{k}.inertia.{axis}" for k in (1, 2) for axis in ("xx", "yy", "zz")]
    wrong = robot.with_values({name: 4 * robot.parameters[name].value for name in names})
    plant = Plant(robot, 0.005, robot.equilibrium(np.array([0.6, 0.4])), substeps=4)
    position, torque = np.empty((4000, 2)), np.empty((4000, 2))
    for k in range(len(position)):
        position[k] = plant.measure()
        torque[k] = 0.2 * np.sin(0.02 * k + np.array([0.0, 1.0])) + 0.05 * rng.standard_normal(2)
        plant.advance(torque[k])
    swinging = Record("log", 0.005, position, torque, np.ones(len(position), dtype=bool), imported=True)
    assert without_foreign_torque(swinging, wrong) is swinging
    noise = replace(swinging, position=record_of_arm(imported=True).position)
    assert without_foreign_torque(replace(noise, torque=wandering(0.2)), wrong).prescribed
