"""A node as a process of its own, as started by `ros2 run` and by the layout processes."""

from __future__ import annotations

import gc
import os
import signal
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from flexros.errors import FlexrosError
from flexros_nodes.protocol.node_report import ERROR_PREFIX, NodeReport
from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.protocol.real_time.precise_timing import take_priority, threads_of_loop
from flexros_nodes.shell.removal import end_within
from flexros_nodes.shell.ros_log_folder import ros_log_settings
from flexros_nodes.shell.shared_memory import become_cleaner
from flexros_nodes.shell.spinning import make_executor, spin

if TYPE_CHECKING:
    from flexros_nodes.protocol.process.interruption import Interruption
    from flexros_nodes.shell.node_base import FlexrosNode

WATCH_PERIOD = 0.02
"""Period at which a node checks whether parent and partners are alive [s], chosen."""

END_TIMEOUT = 5.0
"""Longest time for the middleware to remove a node [s], chosen: it takes about 0.1 s."""


def run_node(node_class: type[FlexrosNode], arguments: list[str] | None = None) -> int:
    """Run one node until it ends, is shut down or interrupted.

    Args:
        node_class: The node.
        arguments: Command line with ROS arguments; default: that of the process.

    Returns:
        Exit code: 0 complete or interrupted, 2 bad input, 3 aborted.
    """
    with interruption() as interrupted:
        try:
            os.environ.update(ros_log_settings(os.environ))
            rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
            report = _run(node_class, interrupted)
        except FlexrosError as error:
            report = NodeReport(node_class.node_name, error.exit_code, str(error))
            _print_error(report)
        finally:
            rclpy.try_shutdown()
    # ros2 launch repeats the SIGINT of the terminal, which must not disturb an orderly shutdown
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if interrupted.parent_died:
        become_cleaner()  # the parent can no longer clean up
    gc.freeze()  # the memory goes with the process: a last search for garbage would take a tenth of a second
    return report.exit_code


def _run(node_class: type[FlexrosNode], interrupted: Interruption) -> NodeReport:
    node = node_class()
    stop: Future = Future()
    node.on_end = lambda _: stop.set_result(None)
    if niceness := node.value("niceness"):
        os.nice(niceness)
    if priority := node.value("priority"):
        take_priority(priority, threads_of_loop())
    node.create_timer(WATCH_PERIOD, partial(_watch_partners, node, stop, interrupted), clock=node.steady_clock)
    executor = make_executor(None)
    executor.add_node(node)
    if node.value("autostart"):
        bring_up(node)
    if node.report is None:
        spin(executor, stop, interrupted, node)
    report = close(node)
    if path := node.value("report_file"):
        report.write(Path(path))
    _print_error(report)
    if _parent_died(node):
        interrupted.parent_died = True  # the process ends at once; its memory takes the middleware with it
        return report
    end_within(END_TIMEOUT, report.exit_code)  # its report is written
    executor.shutdown()
    node.destroy_node()
    return report


def _print_error(report: NodeReport) -> None:
    if report.exit_code:
        print(f"{ERROR_PREFIX}{report.message}", file=sys.stderr, flush=True)


def _watch_partners(node: FlexrosNode, stop: Future, interrupted: Interruption) -> None:
    """End with the parent, and forward the exit of a partner."""
    if _parent_died(node):
        stop.set_result(None)
    if interrupted.partner_ended:
        interrupted.partner_ended = False
        node.partner_ended()


def _parent_died(node: FlexrosNode) -> bool:
    parent = node.value("parent_process")
    return bool(parent) and os.getppid() != parent


def bring_up(node: FlexrosNode) -> None:
    """Configure and activate a node; on failure its report gives the reason."""
    node.trigger_configure()
    if node.report is None and node.configured:  # else it was interrupted
        node.trigger_activate()


def close(node: FlexrosNode) -> NodeReport:
    """Shut a node down unless it has ended, and return its report."""
    if node.report is None:
        node.trigger_shutdown()
    return node.report or NodeReport(node.node_name)
