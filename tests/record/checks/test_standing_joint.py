"""Joints that stand still in a log of a real machine: their motion is prescribed, whatever holds them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml

from flexros.gap.checked_log import checked_log
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.record.checks.standing_joint import without_standing_joints
from flexros.record.record import Record
from flexros.robot import robot_from_data
from tests.gap.rigid_arm import ARM, arm, record_of_arm

ENCODER = 4e-4  # rad


def standing(*, imported: bool = True, driven: float = 0.05, **changes: object) -> Record:
    """Return a log in which the second joint flickers by one step of its encoder at most [torque in Nm]."""
    record = record_of_arm(imported=imported)
    rng, n = np.random.default_rng(0), record.n_samples
    position, torque = record.position.copy(), record.torque.copy()
    position[:, 1] = 0.3 + ENCODER * (rng.random(n) < 0.01)
    torque[:, 1] = torque[:, 1].mean() + driven * rng.normal(size=n)
    return replace(record, position=position, torque=torque, **changes)


@pytest.mark.parametrize("driven", [0.05, 50.0])
def test_the_motion_of_a_standing_joint_is_prescribed(driven: float) -> None:
    """An encoder that flickers is not stuck, whatever the torque: a heavy joint holds against one that moves."""
    record = without_standing_joints(standing(driven=driven), arm())
    assert record.prescribed == (1,)
    assert (
        "the measured motion of motor_2 drives the model there, since it stands still in this log"
        in (record.warnings[-1])
    )
    assert without_standing_joints(record, arm()) is record


def test_a_stuck_encoder_is_no_standing_joint() -> None:
    """A torque that would move a joint whose position never changes is left to the check of the encoder."""
    record = standing(driven=50.0)
    constant = record.position.copy()
    constant[:, 1] = 0.3
    assert without_standing_joints(replace(record, position=constant), arm()).prescribed == ()
    assert without_standing_joints(replace(standing(), position=constant), arm()).prescribed == (1,)
    heavy = replace(record, position=constant, torque=record.torque + np.array([0.0, 300.0]))  # it changes by a sixth
    assert without_standing_joints(heavy, arm()).prescribed == (1,)


def test_several_joints_that_never_move_at_all_stand() -> None:
    """Their torques are noise of the same size as that of the joint that moves; no two encoders are stuck at once."""
    data = yaml.safe_load(ARM)
    data["bodies"].append(data["bodies"][-1])
    data["outputs"]["joints"]["coordinates"].append("body_3.ry")
    robot = robot_from_data(data, "three.yaml")
    record, noise = standing(), np.random.default_rng(1).normal(size=(standing().n_samples, 2))
    position = np.column_stack([record.position[:, 0], np.full((len(noise), 2), 0.3)])
    torque = np.column_stack([record.torque[:, 0], 30.0 * noise])
    held = without_standing_joints(replace(record, position=position, torque=torque), robot)
    assert held.prescribed == (1, 2)


def test_what_stands_still_in_a_log_that_is_only_predicted_counts(tmp_path) -> None:
    """It may move in the fitted one, of which nothing must be lost."""
    table, mapping = tmp_path / "log.csv", tmp_path / "log.yaml"
    record = standing()
    columns = np.column_stack([record.position, record.torque])[:2000]
    np.savetxt(table, columns, delimiter=",", header="q1,q2,u1,u2", comments="")
    lines = [
        f"  - {{column: {name}{k}, quantity: {quantity}, joint: motor_{k}, unit: {unit}}}"
        for name, quantity, unit in (("q", "position", "rad"), ("u", "measured_torque", "Nm"))
        for k in (1, 2)
    ]
    mapping.write_text("\n".join(["name: log", "source: test", "time: {rate: 200}", "columns:", *lines]))
    log = import_log(load_mapping(str(mapping)), [table])
    assert checked_log(log, arm(), name="log").prescribed == (1,)
    assert checked_log(log, arm(), name="log", held_out=True).prescribed == ()


@pytest.mark.parametrize("case", ["all move", "simulated", "none moves"])
def test_other_logs_stay_as_they_are(case: str) -> None:
    record = {"all move": record_of_arm(imported=True), "simulated": standing(imported=False)}.get(case, standing())
    if case == "none moves":
        record = replace(record, position=np.tile(record.position[:1], (record.n_samples, 1)))
    assert without_standing_joints(record, arm()) is record
