"""Gains of the controller as parameters that other nodes set while it runs."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.logs.messages.joint_state import JointStateView
from flexros.logs.stamps import stamp_of
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter as LocalParameter

from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from tests.nodes.loop_on_bench import Loop

NAMES = ("motor_1", "motor_2")
Bench = Any  # the class is in conftest


def double(value: float) -> ParameterValue:
    return ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)


def array(*values: float) -> ParameterValue:
    return ParameterValue(type=ParameterType.PARAMETER_DOUBLE_ARRAY, double_array_value=values)


def setting(bench: Bench, name: str, value: ParameterValue) -> Any:
    """Set a parameter by the service, and return the result."""
    user = bench.hold(rclpy.create_node("user", context=bench.context))
    client = user.create_client(SetParameters, "controller/set_parameters")
    bench.spin_until(client.service_is_ready)
    future = client.call_async(SetParameters.Request(parameters=[Parameter(name=name, value=value)]))
    bench.spin_until(future.done)
    return future.result().results[0]


def test_any_node_may_change_a_gain(bench: Bench) -> None:
    node = bench.add(ControllerNode)
    node.trigger_configure()
    assert setting(bench, "motor_2.kp", double(5.0)).successful
    assert node.controller.gains[node.controller.gain_names.index("motor_2.kp")] == 5.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("motor_1.kp", double(float("nan")), "motor_1.kp out of range Min: 0.0, Max: 1000000000000.0, value: nan"),
        ("motor_1.kp", double(float("inf")), "value: inf"),
        ("motor_1.kd", double(-1.0), "motor_1.kd out of range Min: 0.0, Max: 1000000000000.0, value: -1.0"),
        ("motor_1.ki", double(1e13), "value: 10000000000000.0"),
        ("motor_1.kp", array(1.0, 2.0), "expected 'Type.DOUBLE' got 'Type.DOUBLE_ARRAY'"),
        ("motor_1.kp", ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="1"), "got 'Type.STRING'"),
        ("motor_1.kp", ParameterValue(), "cannot be undeclared"),
        ("motor_3.kp", double(1.0), "undeclared parameter"),
        ("motor_1.kq", double(1.0), "undeclared parameter"),
    ],
)
def test_invalid_gain_is_rejected_and_changes_nothing(
    bench: Bench, name: str, value: ParameterValue, sentence: str
) -> None:
    node = bench.add(ControllerNode)
    node.trigger_configure()
    before = node.controller.gains
    result = setting(bench, name, value)
    assert not result.successful
    assert sentence in result.reason
    assert node.controller.gains.tolist() == before.tolist()
    assert node.report is None


@pytest.mark.slow
def test_change_takes_effect_at_the_reported_sample(
    bench: Bench, short_scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode)
    topics = {name: loop.hear(name) for name in ("joint_states", "joint_reference", "joint_commands")}
    controller = loop.node(ControllerNode)
    said: list[str] = []
    monkeypatch.setattr(controller, "get_logger", lambda: SimpleNamespace(info=said.append))
    loop.bring_up()
    loop.reach(100)
    assert controller.set_parameters([LocalParameter("motor_2.kp", value=1000.0)])[0].successful
    loop.finish()
    bench.spin_until(lambda: all(stamp_of(messages[-1]) == 1_200_000_000 for messages in topics.values()))
    view = JointStateView(NAMES)
    by_stamp = {name: {(s := view.unpack(m)).stamp_ns: s for m in messages} for name, messages in topics.items()}
    told = float(said[0].removeprefix("motor_2.kp = 1000.0 from the sample after stamp ").removesuffix(" s on"))
    law = Experiment.prepare(load_scenario(short_scenario)).controller()
    gains = law.gains
    gains[law.gain_names.index("motor_2.kp")] = 1000.0
    for stamp, state in sorted(by_stamp["joint_states"].items()):
        if stamp > told * 1e9:
            law.gains = gains
        reference = by_stamp["joint_reference"][stamp]
        row = np.array([*reference.position, *reference.velocity, *reference.effort])
        assert tuple(law.step(state.position, row)) == by_stamp["joint_commands"][stamp].effort
    assert 1.04 < told < 1.2


def test_change_before_the_first_sample_is_reported(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    node = bench.add(ControllerNode)
    node.trigger_configure()
    said: list[str] = []
    monkeypatch.setattr(node, "get_logger", lambda: SimpleNamespace(info=said.append))
    node.set_parameters([LocalParameter("motor_1.kp", value=2.0), LocalParameter("motor_1.kd", value=1.0)])
    assert said == ["motor_1.kp = 2.0 from the first sample on", "motor_1.kd = 1.0 from the first sample on"]
