"""flexros replay."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from flexros.cli.commands import replay
from flexros.errors import InputError

SAMPLE = str(Path(__file__).parents[3] / "bags" / "sample_circle_dae")
Command = Callable[..., Any]

needs_ros = pytest.mark.skipif(find_spec("rclpy") is None, reason="needs ROS 2: rclpy cannot be imported")


@pytest.fixture
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand for an installed package of the nodes, whatever the environment knows of its entry points."""
    from importlib.metadata import EntryPoint

    entry = EntryPoint("ros", "flexros_nodes.bringup.replay_run:replay_log", replay.GROUP)
    monkeypatch.setattr(replay.metadata, "entry_points", lambda group: [entry] if group == replay.GROUP else [])


@needs_ros
@pytest.mark.usefixtures("ros_domain", "_installed")
class TestOverRos:
    """Where there are nodes."""

    def test_a_log_is_played(self, flexros: Command) -> None:
        ended = flexros("replay", SAMPLE, "--rate", "inf", "--topic", "joint_states", "--remap", "joint_states:=a/b")
        assert ended.code == 0, ended.err
        assert "/a/b" in ended.out
        assert "762" in ended.out

    def test_figures_are_printed_as_json(self, flexros: Command) -> None:
        ended = flexros("replay", SAMPLE, "--rate", "20", "--from", "0.1", "--to", "0.2", "--clock", "100", "--json")
        assert ended.code == 0, ended.err
        figures = json.loads(ended.out)
        assert figures["/joint_states.messages"] == 201
        assert figures["/clock.messages"] == 11
        assert figures["warnings"] == []

    @pytest.mark.parametrize(
        ("options", "sentence"),
        [
            (("--topic", "joint_state"), "flexros: unknown topic 'joint_state' in"),
            (("--from", "0.3", "--to", "0.1"), "is to go from 0.3 s to 0.1 s, but must begin at 0 s or later"),
            (("--rate", "0"), "flexros: parameter rate of node replay is 0, allowed is a number from 0.001 to 1000"),
            (("--rate", "-inf"), "flexros: parameter rate of node replay is -inf, allowed is a finite number"),
            (("--remap", "a"), "flexros: a topic is renamed by 'a', but must be by old:=new"),
        ],
    )
    def test_bad_input_is_one_sentence(self, flexros: Command, options: tuple[str, ...], sentence: str) -> None:
        ended = flexros("replay", SAMPLE, *options)
        assert ended.code == 2
        assert sentence in ended.err
        assert "Traceback" not in ended.err


def test_the_package_announces_what_plays() -> None:
    setup = (Path(__file__).parents[3] / "setup.py").read_text(encoding="utf-8")
    assert f'"{replay.GROUP}": ["ros = flexros_nodes.bringup.replay_run:replay_log"]' in setup


def test_without_nodes_one_sentence_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replay.metadata, "entry_points", lambda group: [])
    with pytest.raises(InputError, match="a log is played over ROS 2 topics, but the ROS 2 nodes of FlexROS are not"):
        replay.player()
