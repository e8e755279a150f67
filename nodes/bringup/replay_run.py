"""Replaying a log from a program: what `flexros replay` does."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import rclpy
from rclpy.context import Context
from rclpy.task import Future

from flexros.errors import INTERRUPTED, InputError
from flexros_nodes.protocol.parameters import check_value, node_parameters
from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.replay import ReplayNode
from flexros_nodes.shell.domain import DOMAIN_VARIABLE, environment
from flexros_nodes.shell.executable import bring_up, close
from flexros_nodes.shell.exposure import check_exposure, exposure_settings
from flexros_nodes.shell.removal import limited_removal
from flexros_nodes.shell.ros_log_folder import ros_log_settings
from flexros_nodes.shell.spinning import make_executor, spin

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros_nodes.protocol.parameters import Value
    from flexros_nodes.protocol.process.interruption import Interruption

PROGRESS_PERIOD = 0.2
"""Period of progress reports [s], chosen."""


@dataclass(frozen=True)
class ReplaySummary:
    """Result of a replay.

    Attributes:
        exit_code: 0 complete, 3 aborted, 130 interrupted.
        message: Error message in one sentence; empty when all was played.
        warnings: Damage in the log, and topics that were not played.
        figures: Counts by name.
    """

    exit_code: int
    message: str
    warnings: tuple[str, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)


def replay_log(
    values: Mapping[str, Value],
    progress: Callable[[float, float], None] = lambda done, total: None,
    *,
    network: bool = False,
) -> ReplaySummary:
    """Play a log.

    The replay uses the ROS domain of the environment, so that nodes of the user receive it. Its sockets are bound to
    127.0.0.1 unless the environment says otherwise. SIGINT and SIGTERM end it in order.

    Args:
        values: Parameter values of the replay node; "bag" names the log.
        progress: Called periodically with the time played and the total time [s].
        network: Let nodes on other machines receive it.

    Returns:
        Summary with exit code 0, 3 (aborted) or 130 (interrupted).

    Raises:
        InputError: Log, topics, times or a value are not allowed.
        RunError: This process has used ROS 2 before with sockets that are open to the network.
    """
    specifications = node_parameters(ReplayNode.node_name)
    checked = {name: check_value(ReplayNode.node_name, name, value, specifications) for name, value in values.items()}
    settings = exposure_settings(os.environ, network=network)
    with interruption() as interrupted, environment({**settings, **ros_log_settings(os.environ)}):
        summary = _play(checked, progress, interrupted)
    if summary.exit_code == InputError.exit_code:
        raise InputError(summary.message)
    return summary


def _play(
    values: Mapping[str, Value], progress: Callable[[float, float], None], interrupted: Interruption
) -> ReplaySummary:
    context = Context()
    rclpy.init(context=context, args=[])
    node = ReplayNode(context=context, values=values)
    executor = make_executor(context)
    try:
        check_exposure(os.environ, int(os.environ.get(DOMAIN_VARIABLE) or 0))
        node.tells_errors = False  # the summary reports them
        executor.add_node(node)
        stop: Future = Future()
        node.on_end = lambda _: stop.set_result(None)
        bring_up(node)
        if node.report is None:
            node.every(PROGRESS_PERIOD, lambda: progress(node.position, node.duration))
            spin(executor, stop, interrupted, node)
        ended = node.report is not None
        report = close(node)
    finally:
        close(node)
        with limited_removal():
            executor.shutdown()
            node.destroy_node()
            rclpy.try_shutdown(context=context)
    cut_short = interrupted() and not ended
    return ReplaySummary(
        exit_code=INTERRUPTED if cut_short else report.exit_code,
        message="interrupted" if cut_short else report.message,
        warnings=tuple(node.warnings),
        figures=report.figures,
    )
