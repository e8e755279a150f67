"""Visualisation of the plant: robot description, and the arm as markers and frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

from std_msgs.msg import String

from flexros.robot.exchange.urdf.export import urdf_text
from flexros_nodes.plant.arm_frames import ArmFrames
from flexros_nodes.plant.arm_markers import ArmMarkers
from flexros_nodes.shell.topic_interface import period

if TYPE_CHECKING:
    from flexros.scenario.experiment import Experiment
    from flexros.simulate.plant import Plant
    from flexros_nodes.shell.node_base import FlexrosNode

MARKER_PERIOD = period("arm_markers")
"""Period of the markers [s]."""

CHECK_EVERY = 30
"""Marker periods between two checks for subscribers, chosen: a second."""


class PlantView:
    """Publishes the description once (latched), and markers and frames while they have subscribers.

    Nothing is computed without subscribers. In real time all objects are built beforehand: that takes several cycles.

    Args:
        node: The plant node.
        run: The run; the description is that of its nominal robot.
    """

    def __init__(self, node: FlexrosNode, run: Experiment) -> None:
        self._node = node
        text = urdf_text(run.nominal, node.value("description_joints"))
        node.announce("robot_description").publish(String(data=text))
        self.publisher = node.announce("arm_markers")
        self._markers = ArmMarkers(run.plant) if node.value("real_time") else None
        self._frames: ArmFrames | None = None
        if node.value("frames"):
            self._frames = ArmFrames(run.plant, node.value("frame_prefix"))
            self._frame_publisher = node.announce("tf")
        self._wanted = self._frames_wanted = False
        self._calls = 0

    def look_again(self) -> None:
        """Check for subscribers at the next call of `show`."""
        self._calls = 0

    def show(self, plant: Plant) -> None:
        """Publish markers and frames of the present state, if subscribed; call once per marker period."""
        if self._calls % CHECK_EVERY == 0:
            self._wanted = self.publisher.get_subscription_count() > 0
            self._frames_wanted = self._frames is not None and self._frame_publisher.get_subscription_count() > 0
        self._calls += 1
        if self._frames is not None and self._frames_wanted:
            self._frame_publisher.publish(self._frames.fill(self._node.stamp, plant.state))
        if not self._wanted:
            return
        if self._markers is None:
            self._markers = ArmMarkers(plant.robot)
        magnification = self._node.value("magnification")
        self.publisher.publish(self._markers.fill(self._node.stamp, plant.state, magnification))
