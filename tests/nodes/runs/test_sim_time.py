"""Nodes with use_sim_time: their clock follows /clock, and they work as without it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter

from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.identification import IdentificationNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.replay import ReplayNode
from flexros_nodes.shell.node_base import FlexrosNode
from tests.nodes.loop_on_bench import Loop

pytestmark = pytest.mark.slow

SAMPLE_LOG = Path(__file__).parents[3] / "bags" / "sample_circle_dae"
Bench = Any  # the class is in conftest
Differences = Callable[[Log, Log], list[str]]


@pytest.mark.parametrize("leader", [FeedforwardNode, IdentificationNode])
@pytest.mark.parametrize("use_sim_time", [False, True])
def test_log_is_that_of_the_direct_simulation(
    bench: Bench,
    tmp_path: Path,
    short_scenario: Path,
    identification_scenario: Path,
    log_differences: Differences,
    use_sim_time: bool,
    leader: type[FlexrosNode],
) -> None:
    scenario = short_scenario if leader is FeedforwardNode else identification_scenario
    loop = Loop(bench, scenario, RecorderNode, leader, ControllerNode, use_sim_time=use_sim_time)
    loop.node(RecorderNode).set_parameters([Parameter("folder", value=str(tmp_path / "log"))])
    loop.bring_up()
    loop.reach(100)
    loop.call("pause")
    loop.step()
    loop.call("start")
    loop.finish()
    expected = closed_loop(Experiment.prepare(load_scenario(scenario)))
    assert log_differences(expected, read_log(tmp_path / "log")) == []


def test_clock_of_every_node_stops_in_a_pause_and_follows_a_reset(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode, use_sim_time=True)
    nodes = (*loop.others, loop.plant)

    def times() -> list[int]:
        return [node.get_clock().now().nanoseconds for node in nodes]

    loop.bring_up()
    loop.reach(100)
    loop.call("pause")
    at = 1_000_000_000 + loop.sample // 20 * 10_000_000
    bench.spin_until(lambda: times() == [at] * 3)
    bench.spin_for(0.2)
    assert times() == [at] * 3
    loop.call("reset")
    bench.spin_until(lambda: times() == [1_000_000_000] * 3)


def test_time_outs_count_without_any_clock(bench: Bench) -> None:
    plant = bench.add(PlantNode, use_sim_time=True, start_timeout=0.2)
    plant.trigger_configure()
    plant.trigger_activate()
    bench.spin_until(lambda: plant.report is not None)
    assert plant.report.message.startswith("no partners within 0.2 s")


def test_replay_plays_at_its_own_pace(bench: Bench) -> None:
    replay = bench.add(ReplayNode, bag=str(SAMPLE_LOG), use_sim_time=True, rate=10.0, clock_rate=100.0)
    assert replay.trigger_configure() == TransitionCallbackReturn.SUCCESS
    replay.trigger_activate()
    bench.spin_until(lambda: replay.report is not None)
    assert replay.report.exit_code == 0
