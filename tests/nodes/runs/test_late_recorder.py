"""A recorder that discovery brings together with the others late: the loop waits for it and nothing is lost."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.bringup import composed
from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.protocol.loop import shutdown
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.shell.topic_interface import sampled_topics

pytestmark = pytest.mark.usefixtures("ros_domain")

Differences = Callable[[Log, Log], list[str]]
PARAMETERS = {"plant": {"recorder_timeout": 8.0}}


def late(topics: tuple[str, ...], unheard: int) -> type[RecorderNode]:
    """Make a recorder that some topics reach only after their first messages, as before readers are matched."""

    class Late(RecorderNode):
        def listen(self, name: str, callback: Callable[[bytes], None], *, recorder: bool = False) -> None:
            left = [unheard if name in topics else 0]

            def hear(message: bytes) -> None:
                if left[0]:
                    left[0] -= 1
                else:
                    callback(message)

            super().listen(name, hear, recorder=recorder)

    return Late


def mute(unsaid: int) -> type[RecorderNode]:
    """Create a recorder whose first confirmations are lost."""

    class Mute(RecorderNode):
        left = unsaid

        def publish_progress(self, name: str, stamp: int) -> None:
            if self.left:
                self.left -= 1
            else:
                super().publish_progress(name, stamp)

    return Mute


@pytest.mark.parametrize(
    "recorder",
    [*(late((topic,), 3) for topic in sampled_topics()), late(sampled_topics(), 2), mute(6)],
    ids=[*sampled_topics(), "all", "confirmations"],
)
def test_log_of_a_late_recorder_is_complete(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, log_differences: Differences, recorder: type[RecorderNode]
) -> None:
    monkeypatch.setitem(composed.NODE_CLASSES, "recorder", recorder)
    scenario = load_scenario("circle_dae").with_values({"duration": 0.1})
    summary = run_scenario(scenario, tmp_path / "log", parameters=PARAMETERS)
    assert (summary.exit_code, summary.message) == (0, "")
    assert log_differences(closed_loop(Experiment.prepare(scenario)), read_log(tmp_path / "log")) == []


def test_confirmations_lost_in_the_midst_are_said_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, log_differences: Differences
) -> None:
    class Interrupted(RecorderNode):
        left = 30

        def publish_progress(self, name: str, stamp: int) -> None:
            if stamp > 1_020_000_000 and self.left:
                self.left -= 1
            else:
                super().publish_progress(name, stamp)

    monkeypatch.setitem(composed.NODE_CLASSES, "recorder", Interrupted)
    scenario = load_scenario("circle_dae").with_values({"duration": 0.1})
    summary = run_scenario(scenario, tmp_path / "log", parameters=PARAMETERS)
    assert (summary.exit_code, summary.message) == (0, "")
    assert log_differences(closed_loop(Experiment.prepare(scenario)), read_log(tmp_path / "log")) == []


def test_recorder_that_never_receives_the_plant_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(composed.NODE_CLASSES, "recorder", late(("joint_states",), 1_000_000))
    monkeypatch.setattr(shutdown, "FLUSH_TIMEOUT", 0.2)
    parameters = {"plant": {"recorder_timeout": 0.5, "start_timeout": 0.3, "brake_duration": 0.01}}
    summary = run_scenario("circle_dae", tmp_path / "log", parameters=parameters)
    assert summary.exit_code == 3
    assert "the recorder has confirmed nothing after stamp 1.0000 s for 0.5 s" in summary.message


def test_loop_continues_without_tool_reference_of_a_partner(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(composed.NODE_CLASSES, "recorder", late(("tool_reference",), 1_000_000))
    scenario = load_scenario("circle_dae").with_values({"duration": 0.1})
    summary = run_scenario(scenario, tmp_path / "log", parameters=PARAMETERS)
    assert (summary.exit_code, summary.message) == (0, "")
