"""Plant, controller, feedforward and recorder as one process each, for `ros2 launch flexros closed_loop.launch.py`.

Needs a full ROS 2 installation: launch and launch_ros are not on PyPI. `flexros run --layout processes` does the same
without them. The launch ends when the plant ends; the log then lies in `folder`.
"""

from __future__ import annotations

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "scenario": ("circle_pd", "Shipped scenario, or path of a scenario file"),
    "folder": ("bags/run", "Folder of the log, to be made"),
    "real_time": ("false", "Pace the loop by the wall clock instead of lock-step"),
    "namespace": ("", "Namespace of all nodes and topics"),
}

OWN_PARAMETERS = {"recorder": ("folder",), "feedforward": (), "controller": (), "plant": ("real_time",)}
"""Nodes, and those launch arguments that are their own parameters."""

TYPES = {"scenario": str, "folder": str, "real_time": bool}


def generate_launch_description() -> LaunchDescription:
    """Describe the four nodes; each configures and activates itself."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    nodes = [
        Node(
            package="flexros",
            executable=name,
            name=name,
            namespace=LaunchConfiguration("namespace"),
            output="screen",
            parameters=[
                {key: ParameterValue(LaunchConfiguration(key), value_type=TYPES[key]) for key in ("scenario", *own)}
            ],
            on_exit=Shutdown() if name == "plant" else None,
        )
        for name, own in OWN_PARAMETERS.items()
    ]
    return LaunchDescription([*arguments, *nodes])
