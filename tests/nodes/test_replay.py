"""The replay node in the process of the test, and logs played to the nodes that made them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from flexros.logs.messages.joint_state import JointStateTemplate, JointStateView
from flexros.logs.messages.joint_trajectory import read_joint_trajectory
from flexros.logs.messages.schemas import message_schema
from flexros.logs.reader import read_log
from flexros.logs.stamps import stamp_of
from flexros.logs.time_series import Log
from flexros.logs.write_log import write_log
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.identification import IdentificationNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.protocol.parameters import node_parameters
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.replay import ReplayNode
from flexros_nodes.shell.topic_interface import qos_profile, topic

pytestmark = pytest.mark.slow

SAMPLE = Path(__file__).parents[2] / "bags" / "sample_circle_dae"
N_SAMPLE = 762
Bench = Any  # the class is in conftest


def up(*nodes: Any) -> None:
    for node in nodes:
        node.trigger_configure()
    for node in nodes:
        node.trigger_activate()


def replay(bench: Bench, bag: Path = SAMPLE, **values: Any) -> Any:
    node = bench.add(ReplayNode, **{"bag": str(bag), "start_delay": 0.0, "as_fast_as_possible": True, **values})
    node.tells_errors = False
    return node


def hear(node: Any, kind: type, name: str, depth: int = 2000) -> list[bytes]:
    """Gather the messages of a topic as bytes."""
    heard: list[bytes] = []
    node.create_subscription(kind, name, heard.append, depth, raw=True)
    return heard


def texts(path: Path, n: int, spacing: float = 0.1, more: str = "", first: float = 100.0) -> Path:
    """Write a log of texts in steps of time [s], and one message of a type that is nowhere installed."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema(
            "std_msgs/msg/String", "ros2msg", message_schema("std_msgs/msg/String").text.encode()
        )
        channel = writer.register_channel("/told", "cdr", schema)
        for k in range(n):
            time = round((first + k * spacing) * 1e9)
            writer.add_message(channel, time, serialize_message(String(data=f"{k}")), time)
        if more:
            schema = writer.register_schema(more, "ros2msg", b"float64 x\n")
            writer.add_message(writer.register_channel("/more", "cdr", schema), 100 * 10**9, bytes(12), 0)
        writer.finish()
    return path


def test_parameters_are_described_with_their_bounds() -> None:
    for name, specification in node_parameters("replay").items():
        assert specification.description.endswith("."), name
        assert specification.type not in ("int", "double") or specification.bounds is not None, name


# Logs played to the nodes that made them.


@pytest.mark.parametrize("rate", [{"as_fast_as_possible": True}, {"as_fast_as_possible": False, "rate": 2.0}])
def test_a_controller_gives_the_recorded_commands_again_in_every_bit(bench: Bench, rate: dict[str, Any]) -> None:
    controller = bench.add(ControllerNode, observers=0)
    commands = hear(controller, JointState, "joint_commands")
    player = replay(bench, feed_controller=True, **rate)
    up(controller, player)
    bench.spin_until(lambda: player.report is not None, 60.0)
    assert player.report.exit_code == 0, player.report.message
    figures = player.report.figures
    assert (figures["equal_commands"], figures["different_commands"]) == (N_SAMPLE, 0)
    assert figures["commands_without_record"] == 0
    bench.spin_until(lambda: len(commands) >= N_SAMPLE)
    recorded = read_log(SAMPLE).joint_commands
    assert recorded is not None
    view = JointStateView(recorded.names)
    np.testing.assert_array_equal([view.unpack(message).effort for message in commands], recorded.effort)


@pytest.mark.parametrize("scenario", ["two_mass_step", "elbow_moves"])
def test_so_do_controllers_of_other_laws_and_robots(bench: Bench, tmp_path: Path, scenario: str) -> None:
    log = closed_loop(Experiment.prepare(load_scenario(scenario)))
    write_log(log, tmp_path / "log")
    controller = bench.add(ControllerNode, scenario=scenario, observers=0)
    player = replay(bench, tmp_path / "log", feed_controller=True)
    up(controller, player)
    bench.spin_until(lambda: player.report is not None, 60.0)
    figures = player.report.figures
    assert (figures["equal_commands"], figures["different_commands"]) == (len(log.joint_states.stamp), 0)


def test_further_sensors_reach_the_controller_too(bench: Bench, tmp_path: Path) -> None:
    data = load_robot("two_mass").spec.model_dump(mode="json")
    data["sensors"]["tool_imu"] = {"acceleration": {"noise": 0.02, "axes": ["y"]}, "rate": 500}
    (tmp_path / "robot.yaml").write_text(json.dumps(data))
    law = {"kind": "lqg", "effort": 50, "torque_noise": 5, "measurements": ["motor_position", "tool_acceleration"]}
    scenario = {"robot": str(tmp_path / "robot.yaml"), "duration": 0.2, "controller": law}
    step = [{"kind": "step", "at": "motor_1", "start": 0.05, "amplitude": 100}]
    scenario |= {"feedforward": {"method": "none"}, "disturbances": step}
    (tmp_path / "scenario.yaml").write_text(json.dumps(scenario))
    write_log(closed_loop(Experiment.prepare(load_scenario(tmp_path / "scenario.yaml"))), tmp_path / "log")
    player = replay(bench, tmp_path / "log", feed_controller=True)
    up(bench.add(ControllerNode, scenario=str(tmp_path / "scenario.yaml"), observers=0), player)
    bench.spin_until(lambda: player.report is not None, 60.0)
    figures = player.report.figures
    assert (figures["equal_commands"], figures["different_commands"]) == (201, 0)
    assert figures["/tool_imu.messages"] == 101


def test_a_controller_with_another_gain_is_found_out(bench: Bench) -> None:
    controller = bench.add(ControllerNode, observers=0)
    player = replay(bench, feed_controller=True, to_time=0.1)
    controller.trigger_configure()
    controller.set_parameters([Parameter("motor_2.kp", value=134999.0)])
    controller.trigger_activate()
    up(player)
    bench.spin_until(lambda: player.report is not None, 60.0)
    figures = player.report.figures
    assert figures["different_commands"] > 100
    assert figures["equal_commands"] + figures["different_commands"] == 201


def test_late_controller_is_awaited(bench: Bench) -> None:
    player = replay(bench, feed_controller=True, to_time=0.05)
    up(player)
    bench.spin_for(0.5)
    assert player.report is None
    up(bench.add(ControllerNode, observers=0))
    bench.spin_until(lambda: player.report is not None, 60.0)
    assert player.report.figures["equal_commands"] == 101
    assert player.report.figures["measurements_repeated"] > 0


def test_a_controller_that_never_answers_ends_the_replay(bench: Bench) -> None:
    player = replay(bench, feed_controller=True, answer_timeout=0.3)
    up(player)
    bench.spin_until(lambda: player.report is not None)
    assert player.report.exit_code == 3
    assert player.report.message.startswith(
        "no command for the measurement at stamp 1.0000 s arrived within 0.3 s; start a controller with the scenario "
        "of the log and with observers:=0"
    )


def test_a_recorder_writes_the_log_again_in_every_bit(
    bench: Bench, tmp_path: Path, log_differences: Callable[[Log, Log], list[str]]
) -> None:
    recorder = bench.add(RecorderNode, folder=str(tmp_path / "again"))
    player = replay(bench)
    up(recorder, player)
    bench.spin_until(lambda: player.report is not None and recorder.figures()["joint_states.messages"] == N_SAMPLE)
    bench.spin_for(0.2)
    recorder.trigger_shutdown()
    assert log_differences(read_log(SAMPLE), read_log(tmp_path / "again")) == []


def test_a_plant_gives_the_recorded_states_again_when_the_recorded_commands_answer_it(bench: Bench) -> None:
    """To rounding: last bits of a simulation are those of the machine."""
    log = read_log(SAMPLE)
    recorded = log.joint_commands
    assert recorded is not None
    plant = bench.add(PlantNode, observers=0)
    other = bench.hold(rclpy.create_node("player", context=bench.context))
    publisher = other.create_publisher(JointState, "joint_commands", qos_profile(topic("joint_commands").qos))
    command = JointStateTemplate(recorded.names, effort=True)
    efforts = dict(zip(recorded.stamp.tolist(), recorded.effort, strict=True))
    view, found = JointStateView(recorded.names), {}

    def answer(message: bytes) -> None:
        state = view.unpack(message)
        found[state.stamp_ns] = state.position
        publisher.publish(command.fill(state.stamp_ns, effort=efforts[state.stamp_ns]))

    other.create_subscription(JointState, "joint_states", answer, qos_profile(topic("joint_states").qos), raw=True)
    up(plant)
    bench.spin_until(lambda: plant.report is not None, 60.0)
    assert (plant.report.exit_code, plant.report.message) == (0, "")
    assert list(found) == log.joint_states.stamp.tolist()
    np.testing.assert_allclose(list(found.values()), log.joint_states.position, rtol=0, atol=1e-9)


@pytest.mark.parametrize("node_class", [FeedforwardNode, IdentificationNode])
def test_a_leader_streams_the_recorded_reference_again_in_every_bit(
    bench: Bench, tmp_path: Path, identification_scenario: Path, node_class: Any
) -> None:
    scenario = str(identification_scenario) if node_class is IdentificationNode else "circle_dae"
    log = closed_loop(Experiment.prepare(load_scenario(scenario)))
    write_log(log, tmp_path / "log")
    reference = log.joint_reference  # tests/golden compares it with a committed one
    assert reference is not None
    leader = bench.add(node_class, scenario=scenario, observers=0)
    player = replay(
        bench, tmp_path / "log", topics="joint_states", clock_rate=100.0, as_fast_as_possible=False, rate=5.0
    )
    chunks: list[bytes] = []
    profile = qos_profile(topic("joint_reference_ahead").qos)
    player.create_subscription(JointTrajectory, "joint_reference_ahead", chunks.append, profile, raw=True)
    rows: dict[int, np.ndarray] = {}

    def all_there() -> bool:
        while chunks:
            chunk = read_joint_trajectory(chunks.pop())
            values = np.hstack([chunk.positions, chunk.velocities, chunk.effort])
            rows.update(zip((chunk.stamp_ns + chunk.time_from_start).tolist(), values, strict=True))
        return len(rows) == len(reference.stamp)

    up(leader, player)
    bench.spin_until(all_there, 60.0)
    expected = np.hstack([reference.position, reference.velocity, reference.effort])
    np.testing.assert_array_equal([rows[stamp] for stamp in reference.stamp.tolist()], expected)


# Playing.


def test_messages_of_a_foreign_log_are_played_unchanged_and_others_are_named(bench: Bench, tmp_path: Path) -> None:
    player = replay(bench, texts(tmp_path / "a.mcap", 50, more="nowhere_msgs/msg/Thing"), remaps="told:=other/told")
    heard = hear(player, String, "/other/told")
    up(player)
    bench.spin_until(lambda: len(heard) == 50)
    assert heard == [serialize_message(String(data=f"{k}")) for k in range(50)]
    assert player.warnings == [
        "topic /more is not played: the package nowhere_msgs of its type nowhere_msgs/msg/Thing is not installed here"
    ]
    bench.spin_until(lambda: player.report is not None)
    assert player.report.figures == {"messages": 50, "turns": 1, "/other/told.messages": 50}


def test_a_slow_replay_takes_its_time_and_a_clock_goes_with_it(bench: Bench, tmp_path: Path) -> None:
    bag = texts(tmp_path / "a.mcap", 3)
    player = replay(bench, bag, as_fast_as_possible=False, rate=0.5, clock_rate=50.0)
    heard, clock = hear(player, String, "told"), hear(player, Clock, "/clock")
    begin = player.get_clock().now().nanoseconds
    up(player)
    bench.spin_until(lambda: player.report is not None)
    assert player.get_clock().now().nanoseconds - begin >= 0.4e9  # 0.2 s at half the rate
    bench.spin_until(lambda: len(heard) == 3 and len(clock) == 11)
    assert [stamp_of(message) for message in clock] == [100 * 10**9 + k * 20_000_000 for k in range(11)]


def test_a_loop_begins_again_with_the_same_messages(bench: Bench, tmp_path: Path) -> None:
    player = replay(bench, texts(tmp_path / "a.mcap", 4, 0.01), as_fast_as_possible=False, loop=True)
    heard = hear(player, String, "told")
    up(player)
    bench.spin_until(lambda: len(heard) >= 9)
    assert heard[:8] == 2 * [serialize_message(String(data=f"{k}")) for k in range(4)]
    assert player.figures()["turns"] >= 2
    assert player.report is None


def test_pause_and_resume_are_services(bench: Bench, tmp_path: Path) -> None:
    player = replay(bench, texts(tmp_path / "a.mcap", 5), as_fast_as_possible=False, paused=True)
    heard = hear(player, String, "told")
    up(player)

    def ask(name: str) -> str:
        client = player.create_client(Trigger, f"/replay/{name}")
        answer = client.call_async(Trigger.Request())
        bench.spin_until(answer.done)
        assert answer.result().success
        return str(answer.result().message)

    bench.spin_for(0.2)
    assert heard == []
    assert ask("resume") == "playing from 0.000 s on"
    bench.spin_until(lambda: len(heard) == 2)
    assert ask("pause") == "paused at 0.100 s"
    bench.spin_for(0.3)
    assert len(heard) == 2
    assert player.set_parameters([Parameter("rate", value=1000.0)])[0].successful
    ask("resume")
    bench.spin_until(lambda: len(heard) == 5)


def test_log_times_that_no_stamp_can_tell_are_played(bench: Bench, tmp_path: Path) -> None:
    player = replay(bench, texts(tmp_path / "a.mcap", 3, first=1e10), clock_rate=100.0)
    heard = hear(player, String, "told")
    up(player)
    bench.spin_until(lambda: player.report is not None and len(heard) == 3)
    assert player.report.exit_code == 0


def test_a_node_plays_again_after_another_turn_of_its_lifecycle(bench: Bench, tmp_path: Path) -> None:
    player = replay(bench, texts(tmp_path / "a.mcap", 3))
    heard = hear(player, String, "told")
    for turn in (1, 2):
        up(player)
        bench.spin_until(lambda: player.report is not None)
        bench.spin_until(lambda turn=turn: len(heard) == 3 * turn)
        assert player.report.exit_code == 0
        player.trigger_deactivate()
        player.trigger_cleanup()
    assert heard == 2 * [serialize_message(String(data=f"{k}")) for k in range(3)]


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"bag": ""}, "parameter bag of node replay is empty; give a rosbag2 folder or an .mcap file"),
        ({"bag": "nowhere"}, "there is no log at nowhere"),
        ({"topics": "joint_state"}, "unknown topic 'joint_state' in .*: did you mean '/joint_states'"),
        ({"from_time": 0.3, "to_time": 0.2}, "is to go from 0.3 s to 0.2 s, but must"),
        ({"remaps": "joint_states"}, "a topic is renamed by 'joint_states', but must be by old:=new"),
        (
            {"feed_controller": True, "loop": True},
            "feed_controller and loop are both true, but",
        ),
    ],
)
def test_bad_input_is_one_sentence(bench: Bench, values: dict[str, Any], sentence: str) -> None:
    player = replay(bench, **values)
    player.trigger_configure()
    assert player.report.exit_code == 2
    assert re.search(sentence, player.report.message)
