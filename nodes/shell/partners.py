"""Partners of a loop in the graph of ROS 2: one plant, one controller, one reference stream, of FlexROS or the user's.

A node counts by what it does, not by its name: a plant publishes joint_states and subscribes to joint_commands, a
controller the other way round. A gripper that publishes its own joints on joint_states is no plant, and a node that
sends something on joint_commands without hearing measurements is no controller.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from flexros_nodes.shell.claims import PRODUCERS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rclpy.node import Node

HEARS = {"joint_states": "joint_commands", "joint_commands": "joint_states"}
"""Topic to which the producer of a topic subscribes."""

RECORDER = "recorder_progress"
"""Topic by which a recorder is known."""

WATCH_PERIOD = 0.25
"""Period at which plant and controller look for another one [s], chosen: a look takes up to 0.2 ms of a loop in real
time."""


class Partners:
    """Counts plants, controllers and reference streams.

    Args:
        node: Node whose namespace and remappings define the topics.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._names = {topic: node.resolve_topic_name(topic) for topic in (*PRODUCERS, RECORDER)}

    def surplus(self) -> str:
        """Return who is there more than once, as in "2 controllers (/controller, /mine)"; empty if nobody is."""
        found = []
        for topic, producer in PRODUCERS.items():
            if self.publishers(topic) > 1 and (nodes := self._producers(topic)).total() > 1:
                found.append(f"{nodes.total()} {producer}s ({', '.join(sorted(nodes.elements()))})")
        return " and ".join(found)

    def publishers(self, topic: str) -> int:
        """Count the publishers of a topic: `count_publishers` without its checks of the name, a tenth of its time."""
        with self._node.handle:
            return int(self._node.handle.get_count_publishers(self._names[topic]))

    def recorders(self) -> frozenset[bytes]:
        """Return the identifiers of the connected recorders, new ones after each configuration."""
        if not self.publishers(RECORDER):
            return frozenset()
        return frozenset(
            bytes(end.endpoint_gid) for end in self._node.get_publishers_info_by_topic(self._names[RECORDER])
        )

    def _producers(self, topic: str) -> Counter[str]:
        """Return the nodes that produce a topic; of nodes of the same name how many."""
        producers = _nodes(self._node.get_publishers_info_by_topic(self._names[topic]))
        if topic not in HEARS:
            return producers
        return producers & _nodes(self._node.get_subscriptions_info_by_topic(self._names[HEARS[topic]]))


def _nodes(endpoints: Iterable[object]) -> Counter[str]:
    return Counter(f"{end.node_namespace.rstrip('/')}/{end.node_name}" for end in endpoints)  # type: ignore[attr-defined]


def strangers_message(surplus: str) -> str:
    """Report that a run has another one's node as partner.

    Args:
        surplus: Who is there more than once.
    """
    return (
        f"{surplus} share the topics of this run: their messages mix, and the log is not that of one run; end the "
        "other run, or give it a ROS_DOMAIN_ID or namespace of its own"
    )
