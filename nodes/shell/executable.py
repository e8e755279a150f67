"""A node as a process of its own, as `ros2 run` and the layout of processes start it."""

from __future__ import annotations

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
from flexros_nodes.shell.shared_memory import become_cleaner
from flexros_nodes.shell.spinning import make_executor, spin

if TYPE_CHECKING:
    from flexros_nodes.protocol.process.interruption import Interruption
    from flexros_nodes.shell.node_base import FlexrosNode

LOOK_PERIOD = 0.02
"""Period at which a node looks whether parent and partners still live [s], chosen."""

END_TIMEOUT = 5.0
"""Time in which the middleware takes a node away, chosen: it needs some 0.1 s."""


def run_node(node_class: type[FlexrosNode], arguments: list[str] | None = None) -> int:
    """Run one node until it ends, is shut down or interrupted.

    Args:
        node_class: The node.
        arguments: Command line with ROS arguments; that of the process if None.

    Returns:
        Exit code: 0 done or interrupted, 2 bad input, 3 broken off.
    """
    with interruption() as interrupted:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        try:
            report = _run(node_class, interrupted)
        except FlexrosError as error:
            report = NodeReport(node_class.node_name, error.exit_code, str(error))
            _tell(report)
        finally:
            rclpy.try_shutdown()
    # ros2 launch sends the SIGINT of the terminal a second time, which must not spoil a clean end
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if interrupted.parent_died:
        become_cleaner()  # nobody else will clean up behind the parent
    return report.exit_code


def _run(node_class: type[FlexrosNode], interrupted: Interruption) -> NodeReport:
    node = node_class()
    stop: Future = Future()
    node.on_end = lambda _: stop.set_result(None)
    if niceness := node.value("niceness"):
        os.nice(niceness)
    if priority := node.value("priority"):
        take_priority(priority, threads_of_loop())
    node.create_timer(LOOK_PERIOD, partial(_look_around, node, stop, interrupted), clock=node.steady_clock)
    executor = make_executor(None)
    executor.add_node(node)
    if node.value("autostart"):
        bring_up(node)
    if node.report is None:
        spin(executor, stop, interrupted, node)
    report = close(node)
    if path := node.value("report_file"):
        report.write(Path(path))
    _tell(report)
    if _parent_died(node):
        interrupted.parent_died = True  # what the node holds of the middleware goes with the memory of this process
        return report
    end_at_the_latest_after(END_TIMEOUT)
    executor.shutdown()
    node.destroy_node()
    return report


def _tell(report: NodeReport) -> None:
    if report.exit_code:
        print(f"{ERROR_PREFIX}{report.message}", file=sys.stderr, flush=True)


def end_at_the_latest_after(timeout: float) -> None:
    """Let the system end this process by SIGALRM after a time [s]: its work is done, its report written.

    Where Fast DDS was built with an old compiler, as in the wheels, a participant that is taken away just while a
    partner goes may wait for itself, with the lock of Python (eProsima/Fast-DDS issue 6513).

    Args:
        timeout: Time left to the process [s].
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, timeout)


def _look_around(node: FlexrosNode, stop: Future, interrupted: Interruption) -> None:
    """End with the parent, and pass on that a partner has ended."""
    if _parent_died(node):
        stop.set_result(None)
    if interrupted.partner_ended:
        interrupted.partner_ended = False
        node.partner_ended()


def _parent_died(node: FlexrosNode) -> bool:
    parent = node.value("parent_process")
    return bool(parent) and os.getppid() != parent


def bring_up(node: FlexrosNode) -> None:
    """Configure and activate a node; if that fails its report says why."""
    node.trigger_configure()
    if node.report is None:
        node.trigger_activate()


def close(node: FlexrosNode) -> NodeReport:
    """Shut a node down, if it has not ended by itself, and give its report."""
    if node.report is None:
        node.trigger_shutdown()
    return node.report or NodeReport(node.node_name)
