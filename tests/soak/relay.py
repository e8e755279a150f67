"""A node in the middle that loses, repeats and swaps messages: python -m tests.soak.relay SEED SHARE FROM TO ..."""

from __future__ import annotations

import json
import sys
from collections import Counter
from functools import partial
from random import Random

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.task import Future

from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.shell.spinning import make_executor
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic

HELD = 0.003
"""Longest time for which a message waits to be swapped with the next one [s], chosen."""


class Relay(Node):
    """Hands raw messages on, disturbed.

    Args:
        seed: Seed of the disturbances.
        share: Share of the messages that are lost; the same are repeated, the same swapped with the next one [1].
        pairs: Topics, from and to.
    """

    def __init__(self, seed: int, share: float, pairs: list[tuple[str, str]]) -> None:
        super().__init__("relay", start_parameter_services=False)
        self.counts: Counter[str] = Counter()
        self._random, self._share = Random(seed), share
        self._held: dict[str, bytes] = {}
        for origin, target in pairs:
            row = topic(target.rpartition("/")[2])
            publisher = self.create_publisher(message_class(row.type), target, qos_profile(row.qos))
            hand_on = partial(self._hand_on, target, publisher)
            self.create_subscription(message_class(row.type), origin, hand_on, qos_profile(row.qos), raw=True)
            self.create_timer(
                HELD, partial(self._release, target, publisher), clock=Clock(clock_type=ClockType.STEADY_TIME)
            )

    def _hand_on(self, target: str, publisher: Publisher, message: bytes) -> None:
        self.counts["messages"] += 1
        chance = self._random.random() / self._share
        if chance < 1.0:
            self.counts["lost"] += 1
            return
        if chance < 2.0 and target not in self._held:
            self.counts["held back"] += 1
            self._held[target] = message
            return
        publisher.publish(message)
        if chance < 3.0:
            self.counts["repeated"] += 1
            publisher.publish(message)
        if target in self._held:
            self.counts["swapped"] += 1
            publisher.publish(self._held.pop(target))

    def _release(self, target: str, publisher: Publisher) -> None:
        if target in self._held:
            publisher.publish(self._held.pop(target))


def main(seed: str, share: str, *topics: str) -> None:
    """Hand on until SIGTERM, then print what was done."""
    with interruption() as interrupted:
        rclpy.init(args=[], signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
        relay = Relay(int(seed), float(share), list(zip(topics[::2], topics[1::2], strict=True)))
        executor = make_executor(None)
        executor.add_node(relay)
        while not interrupted():
            executor.spin_until_future_complete(Future(), timeout_sec=0.2)
        print(json.dumps(relay.counts))
        executor.shutdown()
        relay.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
