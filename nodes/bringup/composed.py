"""Layout composed: all nodes in one process with one executor, the fastest layout."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import rclpy
from rclpy.context import Context
from rclpy.task import Future

from flexros_nodes.bringup.run_plan import RunSummary, summarise
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.identification import IdentificationNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.shell.domain import DOMAIN_VARIABLE
from flexros_nodes.shell.executable import close
from flexros_nodes.shell.exposure import check_exposure
from flexros_nodes.shell.spinning import make_executor, spin

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rclpy.executors import Executor

    from flexros_nodes.bringup.run_plan import RunPlan
    from flexros_nodes.protocol.process.interruption import Interruption
    from flexros_nodes.shell.node_base import FlexrosNode

NODE_CLASSES: dict[str, type[FlexrosNode]] = {
    node.node_name: node for node in (RecorderNode, FeedforwardNode, IdentificationNode, ControllerNode, PlantNode)
}


def run_composed(plan: RunPlan, interrupted: Interruption) -> RunSummary:
    """Run all nodes of a plan in this process.

    Args:
        plan: What to run.
        interrupted: Returns whether termination was requested.

    Returns:
        Summary of the run.

    Raises:
        InputError: A parameter is not allowed.
    """
    context = Context()
    domain = int(os.environ[DOMAIN_VARIABLE])
    rclpy.init(context=context, args=[], domain_id=domain)
    nodes: list[FlexrosNode] = []
    executor = make_executor(context)
    try:
        for name in plan.nodes:
            nodes.append(NODE_CLASSES[name](context=context, values=plan.values(name)))
            nodes[-1].tells_errors = False  # the summary reports them
            executor.add_node(nodes[-1])
        check_exposure(os.environ, domain)
        _spin_nodes(plan, nodes, executor, interrupted)
        reports = {node.node_name: close(node) for node in reversed(nodes)}
        return summarise(reports, plan.folder, "composed", interrupted=interrupted())
    finally:
        for node in nodes:
            close(node)
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown(context=context)


def _spin_nodes(plan: RunPlan, nodes: Sequence[FlexrosNode], executor: Executor, interrupted: Interruption) -> None:
    """Bring the nodes up and spin until one ends; if it is not the plant, let the plant brake."""
    stop, plant_over = Future(), Future()
    plant = nodes[-1]
    for node in nodes:
        node.on_end = lambda _: stop.set_result(None)

    def end_all(_: FlexrosNode) -> None:
        plant_over.set_result(None)
        stop.set_result(None)

    plant.on_end = end_all
    for node in nodes:
        node.trigger_configure()
        if node.report is not None or interrupted():
            return
    for node in nodes:
        node.trigger_activate()
        if node.report is not None:
            return
    spin(executor, stop, interrupted, plant)
    if not interrupted() and (plan.folder is None or nodes[0].report is None):
        plant.partner_ended()
        spin(executor, plant_over, interrupted, plant)
