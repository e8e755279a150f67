"""The nodes of a run in the test's own process, steered by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger

from flexros_nodes.plant.node import PlantNode
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic


def hear(node: Node, name: str) -> list[bytes]:
    """Let a node collect the messages of a topic."""
    heard: list[bytes] = []
    row = topic(name)
    node.create_subscription(message_class(row.type), row.name, heard.append, qos_profile(row.qos), raw=True)
    return heard


class Loop:
    """The nodes of a run on a bench, with a user who calls the services of the plant."""

    def __init__(
        self, bench: Any, scenario: Path | str, *nodes: type, use_sim_time: bool = False, **plant: Any
    ) -> None:
        self.bench = bench
        common = {"scenario": str(scenario), "observers": int(RecorderNode in nodes), "use_sim_time": use_sim_time}
        self.others = [bench.add(kind, **common) for kind in nodes]
        self.plant = bench.add(PlantNode, **common, **plant)
        self.user = bench.hold(rclpy.create_node("user", context=bench.context))
        self._clients = {
            name: self.user.create_client(Trigger, f"plant/{name}") for name in ("start", "pause", "step", "reset")
        }

    def node(self, kind: type) -> Any:
        return next(node for node in self.others if type(node) is kind)

    def bring_up(self) -> None:
        for node in (*self.others, self.plant):
            node.trigger_configure()
        for node in (*self.others, self.plant):
            node.trigger_activate()

    @property
    def sample(self) -> int:
        return self.plant.loop.sample

    def reach(self, sample: int) -> None:
        self.bench.spin_until(lambda: self.sample >= sample)

    def call(self, name: str) -> Trigger.Response:
        client = self._clients[name]
        self.bench.spin_until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.bench.spin_until(future.done)
        return future.result()

    def step(self) -> None:
        """Step, and wait until the sample is there."""
        before = self.sample
        assert self.call("step").success
        self.bench.spin_until(lambda: self.sample > before)

    def hear(self, name: str) -> list[bytes]:
        """Collect the messages of a topic."""
        return hear(self.user, name)

    def finish(self) -> None:
        self.bench.spin_until(lambda: self.plant.report is not None)
        assert (self.plant.report.exit_code, self.plant.report.message) == (0, "")
        for node in self.others:
            node.trigger_shutdown()
