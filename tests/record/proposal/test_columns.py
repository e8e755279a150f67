"""Columns of a table by the words of their names."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.record.proposal.columns import clock_of_column, table_signals


@pytest.mark.parametrize(("names", "expected"), [
    (["t", "q1", "q2", "dq1", "dq2", "tau1", "tau2"],
     {"position": ["q1", "q2"], "velocity": ["dq1", "dq2"], "measured_torque": ["tau1", "tau2"]}),
    (["time", "u_0", "q_0", "q_d_0"],
     {"position": ["q_0"], "torque_command": ["u_0"], "reference_position": ["q_d_0"]}),
    (["timestamp", "target_q_0", "actual_q_0", "actual_qd_0", "target_qd_0", "target_moment_0"],
     {"position": ["actual_q_0"], "velocity": ["actual_qd_0"], "reference_position": ["target_q_0"],
      "reference_velocity": ["target_qd_0"], "torque_command": ["target_moment_0"]}),
    (["time_ms", "elbowPosition", "shoulderPosition", "elbowTorque", "shoulderTorque"],
     {"position": ["elbowPosition", "shoulderPosition"], "measured_torque": ["elbowTorque", "shoulderTorque"]}),
    (["t", "q[0]", "q[1]", "tau[0]", "tau[1]"],
     {"position": ["q[0]", "q[1]"], "measured_torque": ["tau[0]", "tau[1]"]}),
    (["t", "goal_position", "present_position"],
     {"position": ["present_position"], "position_command": ["goal_position"]}),
    (["time", "position", "velocity", "torque_feedback"],
     {"position": ["position"], "velocity": ["velocity"], "measured_torque": ["torque_feedback"]}),
    (["entries.timestamp", "entries.position", "entries.goal_position", "entries.torque_enable"],
     {"position": ["entries.position"], "position_command": ["entries.goal_position"]}),
    (["log.arm.time", "log.arm.q.0", "log.arm.q.1", "log.arm.tau.0", "log.arm.tau.1"],
     {"position": ["log.arm.q.0", "log.arm.q.1"], "measured_torque": ["log.arm.tau.0", "log.arm.tau.1"]}),
    (["time", "pos_meas1", "pos_filt1", "ang_2", "tau_meas1", "torq_2"],
     {"position": ["pos_meas1", "ang_2"], "measured_torque": ["tau_meas1", "torq_2"]}),
    (["pi_time", "loop_time", "q1", "tau1"], {"position": ["q1"], "measured_torque": ["tau1"]}),
    (["time", "goal_1", "goal_2", "present_1", "present_2", "present_temperature_1"],
     {"position": ["present_1", "present_2"], "position_command": ["goal_1", "goal_2"]}),
    (["t", "target_j1", "actual_j1"], {"position": ["actual_j1"], "position_command": ["target_j1"]}),
    (["timestamp", "action.elbow_flex.pos", "observation.elbow_flex.pos"],
     {"position": ["observation.elbow_flex.pos"], "position_command": ["action.elbow_flex.pos"]}),
    (["Time (sec)", "Angle (rad)", "Speed (rad/sec)", "Torque [N*m]"],
     {"position": ["Angle (rad)"], "velocity": ["Speed (rad/sec)"], "measured_torque": ["Torque [N*m]"]}),
    (["t", "q_rad_1", "dq_rad_s_1", "tau_nm_1", "current_1 [A]"],
     {"position": ["q_rad_1"], "velocity": ["dq_rad_s_1"], "measured_torque": ["tau_nm_1"]}),
    (["t", "posAct", "torDes", "torAct", "accelAct"],
     {"position": ["posAct"], "torque_command": ["torDes"], "measured_torque": ["torAct"]}),
    (["t", "q1", "q1dot", "effort1"], {"position": ["q1"], "velocity": ["q1dot"], "measured_torque": ["effort1"]}),
])  # fmt: skip
def test_usual_names_tell_their_quantity(names: list[str], expected: dict[str, list[str]]) -> None:
    found = table_signals(names, "log.csv")
    assert {quantity: list(own.values()) for quantity, own in found.signals.items()} == expected
    assert found.time == names[0]


def test_numbered_joints_are_in_the_order_of_their_numbers() -> None:
    found = table_signals(["t", *(f"q{k}" for k in (10, 2, 1))], "log.csv")
    assert found.joints == ("1", "2", "10")


def test_named_joints_keep_their_names() -> None:
    found = table_signals(["t", "shoulder_pan_joint_pos", "elbow_joint_pos"], "log.csv")
    assert found.joints == ("shoulder_pan_joint", "elbow_joint")


def test_words_of_measurements_are_no_joints() -> None:
    for names in (["action.elbow_flex.pos", "observation.elbow_flex.pos"], ["goal_elbow_flex", "present_elbow_flex"]):
        found = table_signals(["t", *names], "log.csv")
        assert {tuple(own) for own in found.signals.values()} == {("elbow_flex",)}


def test_a_joint_of_the_model_is_named_whole_beside_a_quantity() -> None:
    names = ["t", "arm/wrist_angle_position", "arm/wrist_angle_position_command", "arm/wrist_angle_effort"]
    found = table_signals(names, "log.csv", joints=("waist", "wrist_angle"))
    assert {quantity: tuple(own) for quantity, own in found.signals.items()} == dict.fromkeys(
        ("position", "reference_position", "measured_torque"), ("arm_wrist_angle",)
    )


def test_a_joint_of_the_model_whose_name_alone_is_a_quantity_is_one() -> None:
    names = ["t", "q1", "dq1", "tau1"]
    assert table_signals(names, "log.csv", joints=("q1",)).signals == table_signals(names, "log.csv").signals


def test_forces_are_what_torques_are() -> None:
    found = table_signals(["t", "x_pos", "tilt_pos", "x_cmd_force", "tilt_cmd_torque", "x_force"], "log.csv")
    assert found.signals["torque_command"] == {"x": "x_cmd_force", "tilt": "tilt_cmd_torque"}
    assert found.signals["measured_torque"] == {"x": "x_force"}


def test_what_is_left_out_has_a_reason() -> None:
    found = table_signals(["t", "q1", "q1_filtered", "tau1", "current1", "ddq1", "temperature"], "log.csv")
    assert {name: reason.split()[0] for name, reason in found.ignored.items()} == {
        "q1_filtered": "q1", "current1": "a", "ddq1": "not", "temperature": "its"
    }  # fmt: skip


def test_currents_stand_for_torques_where_there_are_none() -> None:
    found = table_signals(["t", "q1", "q2", "i1", "i2", "target_current1", "target_current2"], "log.csv")
    assert found.currents == {"measured_torque", "torque_command"}
    assert found.signals["measured_torque"] == {"1": "i1", "2": "i2"}


@pytest.mark.parametrize(
    "names", [["qpos_0", "qvel_0", "cmd_0"], ["jpos0", "jvel0", "jpos0_des"], ["pos_0", "vel_0", "demand_pos_0"]]
)
def test_commands_of_positions_drive_the_robot_where_nothing_else_does(names: list[str]) -> None:
    found = table_signals(["t", *names], "log.csv")
    assert {quantity: own["0"] for quantity, own in found.signals.items()} == dict(
        zip(("position", "velocity", "position_command"), names, strict=True)
    )


def test_commands_that_say_no_quantity_may_be_torques() -> None:
    found = table_signals(["t", "q_0", "cmd_0", "q_des_0"], "log.csv", commands="torque")
    assert found.unnamed == {"0": "cmd_0"}
    assert {quantity: own["0"] for quantity, own in found.signals.items()} == {
        "position": "q_0",
        "torque_command": "cmd_0",
        "reference_position": "q_des_0",
    }


def test_current_may_mean_present() -> None:
    found = table_signals(["t", "current_position1", "current_torque1"], "log.csv")
    assert (set(found.signals), found.currents) == ({"position", "measured_torque"}, set())


def test_names_of_one_quantity_under_one_name_keep_it() -> None:
    assert table_signals(["q.0", "q.1"], "log.npz", timed=False).joints == ("0", "1")


def test_states_of_a_drive_are_no_signals() -> None:
    names = ["t", "q1", "torque1", "torque_enable1", "current_limit1", "position_error1"]
    found = table_signals(names, "log.csv")
    assert (found.joints, list(found.ignored)) == (("1",), names[3:])


def test_what_is_of_the_tool_or_an_inertial_sensor_is_of_no_joint() -> None:
    names = ["t", "q[0]", "q[1]", "ee_pos[0]", "ee_pos[1]", "tcp_speed", "raw_imu_pos"]
    found = table_signals(names, "log.csv")
    assert (found.joints, list(found.ignored)) == (("0", "1"), names[3:])


@pytest.mark.parametrize(
    ("names", "lacking"), [(["t", "a", "b"], "position"), (["q1", "tau1"], "time"), (["q1", "cycle_time"], "time")]
)
def test_a_table_whose_names_tell_nothing_is_refused(names: list[str], lacking: str) -> None:
    with pytest.raises(InputError, match=rf"^log.csv has no column whose name says that it is a {lacking}"):
        table_signals(names, "log.csv")


def test_a_table_of_known_rate_needs_no_times() -> None:
    found = table_signals(["q1", "tau1"], "log.csv", timed=False)
    assert (found.of_table, found.time, found.joints) == (True, "", ("1",))


@pytest.mark.parametrize(("name", "step", "unit"), [
    ("t", 0.002, "s"), ("time", 2.0, "ms"), ("stamp", 2000.0, "us"), ("stamp", 2e6, "ns"), ("t", 0.0, "s"),
    ("time_ms", 1.0, "ms"), ("timestamp_ns", 1e6, "ns"), ("time [s]", 0.1, "s"),
])  # fmt: skip
def test_the_unit_of_times_follows_from_the_name_or_the_rate(name: str, step: float, unit: str) -> None:
    clock = clock_of_column(name, step * np.arange(50.0))
    assert (clock.column, clock.unit) == (name, unit)
