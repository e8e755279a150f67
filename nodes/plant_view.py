"""What others see of the plant beside its signals: the robot's description."""

from __future__ import annotations

from typing import TYPE_CHECKING

from std_msgs.msg import String

from flexros.robot.urdf_file import urdf_text

if TYPE_CHECKING:
    from flexros.simulate.experiment import Experiment
    from flexros_nodes.node_base import FlexrosNode


class PlantView:
    """Publishes the robot's description once, for all who ask later too.

    Args:
        node: The plant node.
        run: What runs; the description is that of its nominal robot.
    """

    def __init__(self, node: FlexrosNode, run: Experiment) -> None:
        text = urdf_text(run.nominal, node.value("description_joints"))
        node.announce("robot_description").publish(String(data=text))
