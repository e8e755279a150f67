"""Showing a running robot in the browser: what `flexros view topics` does."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from visualization_msgs.msg import MarkerArray

from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.shell.domain import environment
from flexros_nodes.shell.exposure import exposure_settings
from flexros_nodes.shell.removal import limited_removal
from flexros_nodes.shell.ros_log_folder import ros_log_settings

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.view.live import LivePage

WAIT = 0.1
"""Longest wait for a message before the end is looked for [s] (chosen)."""


def view_topics(
    page: LivePage, *, namespace: str = "", network: bool = False, ended: Callable[[], bool] = lambda: False
) -> None:
    """Hand the topics of a running robot to a page, until Ctrl-C.

    It only listens, and may lose messages: the run is not slowed.

    Args:
        page: The page.
        namespace: Namespace of the topics.
        network: Listen to nodes on other machines.
        ended: Whether to end.
    """
    settings = exposure_settings(os.environ, network=network)
    with interruption() as interrupted, environment({**settings, **ros_log_settings(os.environ)}):
        context = Context()
        rclpy.init(context=context, args=[])
        node = rclpy.create_node("live_view", context=context, namespace=namespace or None)
        executor = SingleThreadedExecutor(context=context)
        try:
            latest = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
            node.create_subscription(JointState, "joint_states", lambda message: _motors(page, message), latest)
            node.create_subscription(MarkerArray, "arm_markers", lambda message: _bars(page, message), latest)
            executor.add_node(node)
            while not interrupted() and not ended():
                executor.spin_once(timeout_sec=WAIT)
        finally:
            with limited_removal():
                executor.shutdown()
                node.destroy_node()
                rclpy.try_shutdown(context=context)


def _motors(page: LivePage, message: JointState) -> None:
    stamp = message.header.stamp
    page.take_motors(stamp.sec + 1e-9 * stamp.nanosec, message.name, message.position)


def _bars(page: LivePage, message: MarkerArray) -> None:
    ends = {
        marker.ns: np.array([(point.x, point.y, point.z) for point in marker.points]).reshape(-1, 2, 3)
        for marker in message.markers
        if marker.ns in ("true", "stiff")
    }
    if len(ends) == 2:
        page.take_bars(ends["true"], ends["stiff"])
