"""All nodes of a run as one process each, for `ros2 launch flexros closed_loop.launch.py`.

Plant, controller and recorder, and the node that leads the scenario: identification where it has that key, else
feedforward. Needs a full ROS 2 installation: launch and launch_ros are not on PyPI. `flexros run --layout processes`
does the same without them. The launch ends when the plant ends; the log then lies in `folder`.
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from flexros.config.scenario import load_scenario
from flexros_nodes.run_plan import leader_of, nodes_led_by

ARGUMENTS = {
    "scenario": ("circle_pd", "Shipped scenario, or path of a scenario file"),
    "folder": ("bags/run", "Folder of the log, to be made"),
    "real_time": ("false", "Pace the loop by the wall clock instead of lock-step"),
    "begin_at_once": ("true", "Begin an identification at once; false waits for the service ~/start"),
    "namespace": ("", "Namespace of all nodes and topics"),
}

OWN_PARAMETERS = {
    "recorder": ("folder", "real_time"),
    "feedforward": (),
    "identification": ("begin_at_once",),
    "controller": (),
    "plant": ("real_time",),
}
"""Nodes, and those launch arguments that are their own parameters."""

TYPES = {"scenario": str, "folder": str, "real_time": bool, "begin_at_once": bool}


def nodes_of_scenario(context: LaunchContext) -> list[Node]:
    """Describe the nodes that take part; each configures and activates itself."""
    leader = leader_of(load_scenario(LaunchConfiguration("scenario").perform(context)))
    return [
        Node(
            package="flexros",
            executable=name,
            name=name,
            namespace=LaunchConfiguration("namespace"),
            output="screen",
            parameters=[
                {
                    key: ParameterValue(LaunchConfiguration(key), value_type=TYPES[key])
                    for key in ("scenario", *OWN_PARAMETERS[name])
                }
            ],
            on_exit=Shutdown() if name == "plant" else None,
        )
        for name in nodes_led_by(leader)
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes; which nodes depends on the scenario."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=nodes_of_scenario)])
