"""Layout composed: all nodes in one process with one executor, the fastest layout.

In real time only plant and controller share a process. The reference stream and the recorder have one each: preparing
a chunk of the reference takes the time of a cycle, and the thread that compresses and writes the log would hold the
lock of Python, and with it the loop, whenever another program delays it.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import rclpy
from rclpy.context import Context
from rclpy.task import Future

from flexros_nodes.bringup.node_process import NodeProcess
from flexros_nodes.bringup.run_plan import SHUTDOWN_TIMEOUT, RunSummary, summarise
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.identification import IdentificationNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.shell.domain import DOMAIN_VARIABLE
from flexros_nodes.shell.executable import close
from flexros_nodes.shell.exposure import check_exposure
from flexros_nodes.shell.removal import await_departures, limited_removal
from flexros_nodes.shell.shared_memory import remove_segments_without_owner
from flexros_nodes.shell.spinning import make_executor, spin

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rclpy.executors import Executor

    from flexros_nodes.bringup.run_plan import RunPlan
    from flexros_nodes.protocol.process.interruption import Interruption
    from flexros_nodes.shell.node_base import FlexrosNode

NODE_CLASSES: dict[str, type[FlexrosNode]] = {
    node.node_name: node for node in (RecorderNode, FeedforwardNode, IdentificationNode, ControllerNode, PlantNode)
}

RECORDER = RecorderNode.node_name

IN_LOOP = (ControllerNode.node_name, PlantNode.node_name)
"""Nodes of the loop itself."""

WATCH_PERIOD = 0.1
"""Period at which the processes of the other nodes are checked in real time [s], chosen."""


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
    with tempfile.TemporaryDirectory(prefix="flexros_") as scratch, _processes_beside(plan, Path(scratch)) as beside:
        return _run_nodes(plan, interrupted, beside)


@contextmanager
def _processes_beside(plan: RunPlan, scratch: Path) -> Iterator[dict[str, NodeProcess]]:
    """Start the nodes of a run in real time that are not part of its loop, each in a process of its own."""
    names = [name for name in plan.nodes if plan.real_time and name not in IN_LOOP]
    beside = {name: NodeProcess(name, {**plan.process_values(name), "autostart": True}, scratch) for name in names}
    try:
        yield beside
    finally:
        _stop(beside)
        if any(process.killed for process in beside.values()):
            remove_segments_without_owner()


def _stop(beside: Mapping[str, NodeProcess]) -> None:
    """Stop the processes, the recorder last: it was started first."""
    for process in reversed(list(beside.values())):
        process.stop(SHUTDOWN_TIMEOUT)


def _run_nodes(plan: RunPlan, interrupted: Interruption, beside: Mapping[str, NodeProcess]) -> RunSummary:
    context = Context()
    domain = int(os.environ[DOMAIN_VARIABLE])
    rclpy.init(context=context, args=[], domain_id=domain)
    nodes: list[FlexrosNode] = []
    executor = make_executor(context)
    try:
        for name in (name for name in plan.nodes if name not in beside):
            nodes.append(NODE_CLASSES[name](context=context, values=plan.values(name)))
            nodes[-1].tells_errors = False  # the summary reports them
            executor.add_node(nodes[-1])
        check_exposure(os.environ, domain)
        _spin_nodes(nodes, executor, interrupted, beside)
        reports = {node.node_name: close(node) for node in reversed(nodes)}
        _stop(beside)
        await_departures(nodes[0], beside)
        reports |= {name: report for name, process in beside.items() if (report := process.report()) is not None}
        deaths = tuple(death for process in beside.values() if (death := process.death()))
        return summarise(reports, plan.folder, "composed", interrupted=interrupted(), deaths=deaths)
    finally:
        for node in nodes:
            close(node)
        with limited_removal():
            executor.shutdown()
            for node in nodes:
                node.destroy_node()
            rclpy.try_shutdown(context=context)


def _spin_nodes(
    nodes: Sequence[FlexrosNode], executor: Executor, interrupted: Interruption, beside: Mapping[str, NodeProcess]
) -> None:
    """Bring the nodes up and spin until one ends; if it is neither plant nor recorder, let the plant brake."""
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
    if beside:
        plant.create_timer(WATCH_PERIOD, lambda: _end_with(beside, stop), clock=plant.steady_clock)
    spin(executor, stop, interrupted, plant)
    recorder_ended = any(node.node_name == RECORDER and node.report is not None for node in nodes) or (
        RECORDER in beside and beside[RECORDER].ended
    )
    if not interrupted() and not recorder_ended:
        plant.partner_ended()
        spin(executor, plant_over, interrupted, plant)


def _end_with(beside: Mapping[str, NodeProcess], stop: Future) -> None:
    """End the run with a node in a process of its own."""
    if any(process.ended for process in beside.values()):
        stop.set_result(None)
