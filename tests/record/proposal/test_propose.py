"""A mapping proposed for the bag of a UR5e that MuJoCo simulates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.foreign.mapping import Clock
from flexros.record.proposal.propose import propose_mapping, robot_in_bag
from flexros.record.proposal.text import mapping_text
from flexros.robot import load_robot

pytestmark = pytest.mark.slow

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)


def about(proposal, subject: str) -> list:
    return [each for each in proposal.assumptions if each.about == subject]


def test_joints_by_name_and_signs_of_the_urdf(written, ur5e, measured) -> None:
    found = propose_mapping(written(), ur5e)
    columns = {(entry.quantity, entry.joint): entry for entry in found.mapping.columns}
    for k, name in enumerate(JOINTS, start=1):
        for quantity, field, unit in (
            ("position", "position", "rad"),
            ("velocity", "velocity", "rad/s"),
            ("measured_torque", "effort", "Nm"),
        ):
            entry = columns[quantity, f"motor_{k}"]
            assert entry.column == f"/joint_states.{field}[{name}]"
            assert (entry.unit, entry.sign) == (unit, -1 if name == "wrist_2_joint" else 1)
    position = found.log.joint_states.position
    assert np.allclose(position * [1, 1, 1, 1, -1, 1], measured[0])


def test_effort_is_a_torque_though_a_load_and_friction_are_unknown(written, ur5e) -> None:
    (effort,) = about(propose_mapping(written(), ur5e), "effort")
    assert effort.checked
    assert "torque in Nm" in effort.taken


def test_effort_is_a_current_where_the_weights_say_so(written, ur5e) -> None:
    constants = np.array([10.0, 10.7, 8.5, 9.0, 9.5, 10.1])
    found = propose_mapping(written(torque=1 / constants), ur5e)
    scales = {e.joint: e.scale for e in found.mapping.columns if e.quantity == "measured_torque"}
    assert {scale.unit for scale in scales.values()} == {"Nm/A"}
    for motor, constant in (("motor_2", 10.7), ("motor_3", 8.5)):  # those that carry the weight, with the unknown load
        assert scales[motor].value == pytest.approx(constant / 1.3, rel=0.15)
    (effort,) = about(found, "effort")
    assert not effort.checked


@pytest.fixture
def table_of_currents(measured, tmp_path: Path) -> Path:
    """The positions of the UR5e with currents of 1 Nm/A at all motors."""
    q, torque = (one * [1, 1, 1, 1, -1, 1] for one in measured)
    names = ",".join(["t", *(f"q{k}" for k in range(6)), *(f"current{k}" for k in range(6))])
    time = np.arange(len(q)) / 500
    np.savetxt(tmp_path / "run.csv", np.column_stack([time, q, torque]), delimiter=",", header=names, comments="")
    return tmp_path / "run.csv"


def test_currents_of_a_table_get_constants_that_make_the_weights_true(table_of_currents: Path, ur5e) -> None:
    found = propose_mapping(table_of_currents, ur5e)
    of_torque = [one for one in found.mapping.columns if one.quantity == "measured_torque"]
    assert [one.column for one in of_torque] == [f"current{k}" for k in range(6)]
    assert of_torque[1].scale.value == pytest.approx(1 / 1.3, rel=0.15)  # with the unknown load, as above
    assert "a current in A" in about(found, "effort")[0].taken


def test_currents_without_a_model_are_left_out(table_of_currents: Path) -> None:
    found = propose_mapping(table_of_currents, None)
    assert {one.quantity for one in found.mapping.columns} == {"position"}
    assert "current0 to current5 (a current needs a torque constant: give a model" in about(found, "others")[0].taken


def test_opposite_efforts_are_turned_round(written, ur5e) -> None:
    found = propose_mapping(written(torque=-1.0), ur5e)
    signs = {e.joint: e.sign for e in found.mapping.columns if e.quantity == "measured_torque"}
    assert (signs["motor_2"], signs["motor_3"], signs["motor_5"]) == (-1, -1, 1)  # motor_5 counts against its joint


@pytest.mark.parametrize(("size", "unit"), [(1.0, "rad"), (57.3, "deg")])
def test_turns_per_minute_are_seen(size: float, unit: str, tmp_path) -> None:
    time = np.arange(600) / 100
    table = np.column_stack([time, size * 2 * np.sin(time), 60 / (2 * np.pi) * 2 * np.cos(time), np.cos(time)])
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header="time,q1,dq1,tau1", comments="")
    found = propose_mapping(tmp_path / "log.csv", None)
    units = {one.quantity: one.unit for one in found.mapping.columns}
    assert (units["position"], units["velocity"]) == (unit, "rpm")
    assert about(found, "position")[0].taken == f"in {unit}"


def test_degrees_are_seen(written, ur5e, measured) -> None:
    found = propose_mapping(written(position=np.degrees(1.0)), ur5e)
    assert {e.unit for e in found.mapping.columns if e.quantity == "position"} == {"deg"}
    assert {e.unit for e in found.mapping.columns if e.quantity == "velocity"} == {"deg/s"}
    assert np.allclose(found.log.joint_states.position[:, 0], measured[0][:, 0])


def test_prefixed_names_are_those_of_the_model(written, ur5e) -> None:
    found = propose_mapping(written(prefix="left_"), ur5e)
    assert "/joint_states.position[left_elbow_joint]" in {entry.column for entry in found.mapping.columns}


def test_without_a_model_nothing_is_compared(written) -> None:
    found = propose_mapping(written(), None)
    assert about(found, "joints")[0].checked is False
    assert about(found, "effort")[0].checked is False
    assert found.mapping.columns[0].column == "/joint_states.position[shoulder_lift_joint]"


def test_robot_of_the_description_in_the_bag(written) -> None:
    robot = robot_in_bag(written())
    assert robot is not None
    assert robot.spec.tags["motor_5.joint_sign"] == "-1"
    assert robot.spec.tags["motor_6.joint"] == "wrist_3_joint"


def test_bag_of_another_robot_is_refused(written) -> None:
    with pytest.raises(InputError, match="robot elbow"):
        propose_mapping(written(), load_robot("elbow"))


def test_a_table_is_proposed_by_the_names_of_its_columns(tmp_path: Path) -> None:
    """Cells that are empty and times that repeat are normal life."""
    time = np.arange(2000) / 100
    q = np.rad2deg(np.column_stack([2 * np.sin(time), np.cos(time)]))
    rows = np.column_stack([1e3 * time, q, 0.1 * q])
    rows[3, 1], rows[7, 0] = np.nan, rows[6, 0]
    file = tmp_path / "run.csv"
    np.savetxt(file, rows, delimiter=",", header="time,q2,q1,tau2,tau1", comments="")
    found = propose_mapping(file, None)
    assert found.mapping.time == Clock(column="time", unit="ms")
    assert [(one.column, one.joint, one.unit) for one in found.mapping.columns] == [
        ("q1", "motor_1", "deg"), ("q2", "motor_2", "deg"), ("tau1", "motor_1", "Nm"), ("tau2", "motor_2", "Nm"),
    ]  # fmt: skip
    assert found.log.joint_states.position is not None
    assert found.log.joint_states.position[0] == pytest.approx([1.0, 0.0])
    assert "names of columns say so" in about(found, "effort")[0].ground


def test_a_table_without_times_takes_the_rate_that_is_given(tmp_path: Path) -> None:
    """Columns of joints without a position, such as estimated external torques, are left out and said to be."""
    time = np.arange(500) / 100
    file = tmp_path / "run.csv"
    rows = np.column_stack([np.sin(time), np.cos(time), 0 * time])
    np.savetxt(file, rows, delimiter=",", header="q_0,tau_0,tau_ext_0", comments="")
    with pytest.raises(InputError, match="no column whose name says that it is a time") as told:
        propose_mapping(file, None)
    assert told.value.argument == "rate"
    found = propose_mapping(file, None, rate=100.0)
    assert found.mapping.time == Clock(rate=100.0)
    assert "rate: 100" in mapping_text(found.mapping, found.assumptions)
    assert [one.column for one in found.mapping.columns] == ["q_0", "tau_0"]
    assert "tau_ext_0" not in about(found, "columns")[0].taken
    assert "tau_ext_0" in about(found, "others")[0].taken
    assert "100 Hz" in about(found, "rate")[0].taken


@pytest.mark.parametrize("rate", [-5.0, 0.0, float("nan"), 1e9])
def test_a_rate_that_is_none_is_refused(rate: float, tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    np.savetxt(file, np.ones((500, 2)), delimiter=",", header="q_0,tau_0", comments="")
    with pytest.raises(InputError, match="rate"):
        propose_mapping(file, None, rate=rate)


def test_the_mapping_has_the_rate_of_the_log(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    q = np.sin(np.arange(500) / 100)
    np.savetxt(file, np.column_stack([q, -q]), delimiter=",", header="q_0,tau_0", comments="")
    found = propose_mapping(file, None, rate=187.469921)
    assert "rate: 187.469921" in mapping_text(found.mapping, found.assumptions)


def test_a_bag_has_times_of_its_own(written) -> None:
    with pytest.raises(InputError, match="leave the rate out"):
        propose_mapping(written(), None, rate=100.0)


@pytest.mark.parametrize(("rate", "named"), [(None, {"t": np.arange(500) / 250}), (250.0, {})])
def test_columns_of_unequal_length_are_refused_with_their_lengths(rate: float | None, named, tmp_path: Path) -> None:
    file = tmp_path / "run.npz"
    np.savez(file, **named, q1=np.sin(np.arange(500) / 50), tau1=np.zeros(400))
    with pytest.raises(InputError, match=r"has 400 rows in column 'tau1' and 500 times; make them equally long"):
        propose_mapping(file, None, rate=rate)


def test_joints_of_other_names_are_guessed_by_their_order(tmp_path: Path) -> None:
    """What is no joint, as an inertial sensor, does not count among them."""
    time = np.arange(500) / 100
    file, names = tmp_path / "run.csv", "t,shoulder_pos,elbow_pos,raw_imu_pos"
    rows = np.column_stack([time, np.sin(time), np.cos(time), time])
    np.savetxt(file, rows, delimiter=",", header=names, comments="")
    (joints,) = about(propose_mapping(file, load_robot("elbow")), "joints")
    assert joints.taken == "motor_1 = shoulder, motor_2 = elbow"
    assert ("guessed by their order" in joints.ground, joints.checked) == (True, False)


def test_a_column_of_a_table_that_lacks_a_joint_is_said_with_its_name(tmp_path: Path) -> None:
    time = np.arange(500) / 100
    file = tmp_path / "run.csv"
    np.savetxt(file, np.column_stack([time, time, time]), delimiter=",", header="t,position,torque_left", comments="")
    found = propose_mapping(file, None)
    assert "without usable values of the only joint, but of left" in about(found, "others")[0].taken
    assert "motor_1 = the only joint" in about(found, "joints")[0].taken
    assert "no column" in about(found, "effort")[0].ground


def test_degrees_are_not_checked_where_a_joint_may_turn_round_and_round(tmp_path: Path) -> None:
    """A drive on a bench: no weight tells degrees from radians."""
    time = np.arange(2000) / 100
    file = tmp_path / "bench.csv"
    np.savetxt(file, np.column_stack([time, 5 * time, 0 * time]), delimiter=",", header="t,q,tau", comments="")
    (position,) = about(propose_mapping(file, None), "position")
    assert (position.taken, position.checked) == ("in deg", False)


def _table(folder: Path, **columns: np.ndarray) -> Path:
    """Write columns of 500 rows at 100 Hz, without times in seconds."""
    time = np.arange(500) / 100
    rows, names = np.column_stack([time, *columns.values()]), ",".join(["time", *columns])
    np.savetxt(folder / "run.csv", rows, delimiter=",", header=names, comments="")
    return folder / "run.csv"


def test_units_in_names_decide(tmp_path: Path) -> None:
    """Though the joint leaves two turns, and the torque is a thousand times as large."""
    time = np.arange(500) / 100
    columns = {"Angle (rad)": 40 * np.sin(time), "Speed (rad/sec)": 40 * np.cos(time), "tau [mNm]": np.cos(time)}
    found = propose_mapping(_table(tmp_path, **columns), None)
    assert [one.unit for one in found.mapping.columns] == ["rad", "rad/s", "mNm"]
    assert [about(found, subject)[0].checked for subject in ("position", "velocity", "effort")] == [True] * 3
    assert about(found, "position")[0].ground == "names of columns say so"


def test_a_current_that_is_left_out_is_no_torque_and_commanded_positions_drive(tmp_path: Path) -> None:
    time = np.arange(500) / 100
    columns = {"pos_0": np.sin(time), "cmd_0": np.sin(time + 0.1), "cur_0": np.cos(time)}
    found = propose_mapping(_table(tmp_path, **columns), None)
    assert [one.quantity for one in found.mapping.columns] == ["position", "position_command"]
    assert about(found, "columns")[0].taken == "position: pos_0; position command: cmd_0"
    (effort,) = about(found, "effort")
    assert effort.taken == "no torque: the position commands drive the servos of the robot file"
    assert effort.ground == "the currents have no known torque constant"


def test_commanded_torques_that_are_zero_beside_measured_ones_are_left_out(tmp_path: Path) -> None:
    time = np.arange(500) / 100
    columns = {"pos": np.sin(time), "torDes": 0 * time, "torAct": np.cos(time)}
    found = propose_mapping(_table(tmp_path, **columns), None)
    assert [one.quantity for one in found.mapping.columns] == ["position", "measured_torque"]
    assert "torDes (all zero)" in about(found, "others")[0].taken


def test_position_commands_without_a_torque_are_said_to_drive_the_servos(tmp_path: Path) -> None:
    time = np.arange(500) / 100
    file = tmp_path / "run.csv"
    rows = np.column_stack([time, np.sin(time), np.sin(time + 0.1)])
    np.savetxt(file, rows, delimiter=",", header="t,position,goal_position", comments="")
    (effort,) = about(propose_mapping(file, None), "effort")
    assert effort.taken == "no torque: the position commands drive the servos of the robot file"


def test_commands_that_say_no_quantity_are_torques_far_from_the_positions(tmp_path: Path) -> None:
    found = propose_mapping(_commanded(tmp_path, 30.0), None)
    assert {(one.column, one.quantity) for one in found.mapping.columns if one.column.startswith("cmd")} == {
        ("cmd_A", "torque_command"),
        ("cmd_B", "torque_command"),
    }
    (commands,) = about(found, "commands")
    assert (commands.taken, commands.checked) == ("cmd_A, cmd_B: torque commands", True)
    assert "values far from the positions say so" in about(found, "effort")[0].ground


def test_commands_that_say_no_quantity_are_positions_near_the_positions(tmp_path: Path) -> None:
    found = propose_mapping(_commanded(tmp_path, 1.05), None)
    assert "position_command" in {one.quantity for one in found.mapping.columns}
    assert about(found, "commands")[0].taken == "cmd_A, cmd_B: position commands"


def _commanded(folder: Path, size: float) -> Path:
    """Write commands of some size over the positions, with a joint that has no position."""
    time = np.arange(500) / 100
    q = np.column_stack([np.sin(time), np.cos(time)])
    rows = np.column_stack([time, q, size * q, 100 * time])
    np.savetxt(folder / "run.csv", rows, delimiter=",", header="t,q_A,q_B,cmd_A,cmd_B,cmd_gripper", comments="")
    return folder / "run.csv"
