"""Feedforward node: when it begins to send the reference."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy

from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.shell import reference_stream
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic
from tests.nodes.loop_on_bench import hear

Bench = Any  # the class is in conftest


def test_reference_waits_for_a_clock_and_says_so(
    bench: Bench, short_scenario: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(reference_stream, "PATIENCE", 0.3)
    node = bench.add(FeedforwardNode, scenario=str(short_scenario), observers=0)
    user = bench.hold(rclpy.create_node("user", context=bench.context))
    chunks = hear(user, "joint_reference_ahead")
    node.trigger_configure()
    node.trigger_activate()
    bench.spin_until(lambda: "the reference waits for" in capfd.readouterr().err)
    assert not chunks

    clock = topic("clock")
    user.create_publisher(message_class(clock.type), clock.name, qos_profile(clock.qos))
    bench.spin_until(lambda: bool(chunks))
