"""A node that floods a topic with what does not belong there: python -m tests.soak.flood KIND RATE."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from random import Random
from time import perf_counter, sleep

import numpy as np
import rclpy
from std_msgs.msg import String

from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk, serialise_joint_trajectory
from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic

NAMES = ("motor_1", "motor_2")
HEADER = b"\x00\x01\x00\x00"
MANY = 200
"""Messages that are made in advance."""


def _bytes(random: Random) -> bytes:
    return HEADER + random.randbytes(random.randrange(300))


def _size(random: Random) -> bytes:
    names = tuple(f"motor_{i}" for i in range(random.choice((1, 50))))
    return JointStateTemplate(names, effort=True).fill(random.randrange(2**60), effort=[1.0] * len(names))


def _not_finite(random: Random) -> bytes:
    effort = [random.choice((float("nan"), float("inf"), -float("inf"))) for _ in NAMES]
    return JointStateTemplate(NAMES, effort=True).fill(random.randrange(10**9), effort=effort)


def _denormal(random: Random) -> bytes:
    effort = [random.choice((1, -1)) * random.random() * sys.float_info.min for _ in NAMES]
    return JointStateTemplate(NAMES, effort=True).fill(random.randrange(10**9), effort=effort)


def _trajectory(random: Random) -> bytes:
    names, times, value = random.choice(
        (
            (NAMES, [0, 10**9], float("nan")),
            (NAMES, [10, 10], 0.0),
            (("wrist", "thumb"), [0, 10**9], 0.0),
        )
    )
    return serialise_joint_trajectory(JointTrajectoryChunk(0, names, np.array(times), np.full((2, 2), value)))


def _text(_: Random) -> String:
    return String(data="not a command")


KINDS: dict[str, tuple[str, Callable[[Random], object]]] = {
    "bytes": ("joint_commands", _bytes),
    "sizes": ("joint_commands", _size),
    "not_finite": ("joint_commands", _not_finite),
    "denormal": ("joint_commands", _denormal),
    "trajectories": ("joint_trajectory", _bytes),
    "bad_trajectories": ("joint_trajectory", _trajectory),
    "type": ("joint_commands", _text),
}


def main(kind: str, rate: str) -> None:
    """Flood until SIGTERM, then print how much was sent."""
    name, make = KINDS[kind]
    row, random = topic(name), Random(kind)
    messages = [make(random) for _ in range(MANY)]
    with interruption() as interrupted:
        rclpy.init(args=[], signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
        node = rclpy.create_node("flood", start_parameter_services=False)
        message_type = String if kind == "type" else message_class(row.type)
        publisher = node.create_publisher(message_type, row.name, qos_profile(row.qos))
        sent, began = 0, perf_counter()
        while not interrupted():
            due = round((perf_counter() - began) * float(rate))
            for _ in range(min(due - sent, 100)):
                publisher.publish(messages[sent % MANY])
                sent += 1
            sleep(1e-3)
        print(json.dumps({"sent": sent, "rate": sent / (perf_counter() - began)}))
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
