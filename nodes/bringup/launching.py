"""Launch descriptions for `nodes/launch`: arguments, and one process per node.

The packages launch and launch_ros exist only in a full ROS 2 installation, so they are imported when a launch file asks
for its description. `flexros run --layout processes` starts the same nodes without them.
"""

from __future__ import annotations

import shutil
import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.errors import FlexrosError
from flexros_nodes.bringup.launch_plan import (
    COMMON_ARGUMENTS,
    ROBOTS,
    Argument,
    plan_launch,
    plan_robots,
    run_arguments,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from launch import LaunchContext, LaunchDescription
    from launch.action import Action
    from launch_ros.actions import Node

    from flexros_nodes.bringup.launch_plan import LaunchPlan, NodeStart


def run_description(*scenarios: str) -> LaunchDescription:
    """Describe the run of one robot.

    Args:
        *scenarios: Built-in scenarios of the experiment, the default first.

    Returns:
        Arguments and nodes; the nodes depend on the scenario. The launch ends with the plant.
    """
    return _description(run_arguments(scenarios), lambda given, scratch: (plan_launch(given, scratch),))


def robots_description() -> LaunchDescription:
    """Describe several robots, each in a namespace; the launch ends when all plants have ended."""
    return _description({"robots": ROBOTS, **COMMON_ARGUMENTS}, plan_robots)


def _description(
    arguments: Mapping[str, Argument], plan: Callable[[Mapping[str, str], Path], tuple[LaunchPlan, ...]]
) -> LaunchDescription:
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler
    from launch.event_handlers import OnShutdown

    def start(context: LaunchContext) -> list[Action]:
        given = {name: context.launch_configurations[name] for name in arguments}
        scratch = Path(tempfile.mkdtemp(prefix="flexros_launch_"))
        tidy = partial(shutil.rmtree, scratch, ignore_errors=True)
        try:
            actions = _actions(plan(given, scratch))
        except FlexrosError:
            tidy()
            raise
        return [RegisterEventHandler(OnShutdown(on_shutdown=lambda event, context: tidy())), *actions]

    declared = [
        DeclareLaunchArgument(
            name,
            default_value=argument.default,
            description=argument.description,
            choices=list(argument.choices) or None,
        )
        for name, argument in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def _actions(plans: tuple[LaunchPlan, ...]) -> list[Action]:
    """Create the nodes of all plans, and print the folders of their logs."""
    from launch.actions import LogInfo, OpaqueFunction, Shutdown

    running = {plan.namespace for plan in plans}

    def ended(namespace: str) -> Callable[[LaunchContext], list[Action]]:
        def note(context: LaunchContext) -> list[Action]:
            running.discard(namespace)
            return [] if running else [Shutdown(reason="the run is over")]

        return note

    actions: list[Action] = []
    for plan in plans:
        if plan.folder is not None:
            actions.append(LogInfo(msg=f"log: {plan.folder}"))
        over = OpaqueFunction(function=ended(plan.namespace))
        actions += [_node(plan, node, [over] if node.leads_end else None) for node in plan.nodes]
    return actions


def _node(plan: LaunchPlan, node: NodeStart, on_exit: list[Action] | None) -> Node:
    from launch_ros.actions import Node
    from launch_ros.parameter_descriptions import ParameterValue

    # an untyped text would be parsed as YAML: a scenario named 1 would become a number
    typed = {name: ParameterValue(value, value_type=type(value)) for name, value in node.parameters.items()}
    return Node(
        package="flexros",
        executable=node.name,
        name=node.name,
        namespace=plan.namespace or None,
        parameters=[typed, *([plan.params_file] if plan.params_file else [])],
        remappings=list(plan.remappings) or None,
        output="screen",
        on_exit=on_exit,
    )
