"""Replaying a log from a program, and as an executable."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.writer import Writer

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.serialization import serialize_message
from std_msgs.msg import String

from flexros.errors import InputError
from flexros.logs.messages.schemas import message_schema
from flexros_nodes.bringup.replay_run import replay_log

SAMPLE = Path(__file__).parents[3] / "bags" / "sample_circle_dae"
TIMEOUT = 60.0

pytestmark = pytest.mark.usefixtures("ros_domain")


def test_a_log_is_played_and_summed_up() -> None:
    told: list[tuple[float, float]] = []
    values = {"bag": str(SAMPLE), "rate": 1.0, "start_delay": 0.0, "topics": "joint_states,/tool_pose"}
    summary = replay_log(values, lambda done, total: told.append((done, total)))
    assert (summary.exit_code, summary.message, summary.warnings) == (0, "", ())
    assert summary.figures["messages"] == 2 * 762
    assert told
    assert all(0.0 <= done <= total == pytest.approx(0.3805) for done, total in told)


def test_a_log_that_was_cut_off_is_played_with_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=500)
        writer.start(profile="ros2")
        text = message_schema("std_msgs/msg/String").text.encode()
        channel = writer.register_channel(
            "/told", "cdr", writer.register_schema("std_msgs/msg/String", "ros2msg", text)
        )
        for k in range(100):
            writer.add_message(channel, k, serialize_message(String(data=f"message {k}")), k)
        writer.finish()
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    summary = replay_log({"bag": str(path), "as_fast_as_possible": True, "start_delay": 0.0})
    assert summary.exit_code == 0
    assert "is truncated at byte" in summary.warnings[0]
    assert 10 < summary.figures["messages"] < 100


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"rate": 0.0}, "parameter rate of node replay is 0, allowed is a number from 0.001 to 1000"),
        ({"rate": -1.0}, "parameter rate of node replay is -1, allowed"),
        ({"rate": float("nan")}, "parameter rate of node replay is nan, allowed is a finite number"),
        ({"from_time": 3.0}, "the replay is to begin at 3 s, but .* lasts only 0.38"),
    ],
)
def test_bad_input_is_raised(values: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        replay_log({"bag": str(SAMPLE), **values})


def test_a_controller_in_a_process_of_its_own_gives_the_recorded_commands_again(
    start_node: Callable[..., subprocess.Popen[str]],
) -> None:
    controller = start_node("controller", "scenario:=circle_dae", "observers:=0")
    try:
        summary = replay_log({"bag": str(SAMPLE), "as_fast_as_possible": True, "feed_controller": True})
    finally:
        controller.send_signal(signal.SIGTERM)
        _, errors = controller.communicate(timeout=TIMEOUT)
    assert controller.returncode == 0, errors
    assert (summary.figures["equal_commands"], summary.figures["different_commands"]) == (762, 0)


def test_the_executable_plays_a_log(start_node: Callable[..., subprocess.Popen[str]]) -> None:
    process = start_node("replay", f"bag:={SAMPLE}", "as_fast_as_possible:=true")
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 0, errors


def test_a_signal_ends_a_loop_in_order(start_node: Callable[..., subprocess.Popen[str]]) -> None:
    process = start_node("replay", f"bag:={SAMPLE}", "loop:=true")
    with pytest.raises(subprocess.TimeoutExpired):
        process.communicate(timeout=3.0)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 0, errors
    assert "Traceback" not in errors
