"""What all nodes share beside parameters and topics: lifecycle, diagnostics and the way a node ends."""

from __future__ import annotations

import traceback
from abc import abstractmethod
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.exceptions import InvalidHandle
from rclpy.lifecycle import TransitionCallbackReturn

from flexros.errors import INTERNAL_ERROR, FlexrosError
from flexros.logs.stamps import NANOSECONDS, START_NS
from flexros_nodes.protocol.node_report import NodeReport
from flexros_nodes.protocol.parameters import node_parameters
from flexros_nodes.shell.lifecycle_service import refuse_impossible_transitions
from flexros_nodes.shell.topic_node import AbstractTopicNode

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rclpy.context import Context
    from rclpy.lifecycle import LifecycleState

    from flexros_nodes.protocol.parameters import Value
    from flexros_nodes.protocol.real_time.schedule import Paced


class NodeFaultError(FlexrosError):
    """A fault in a node itself; its traceback is in the node's output."""

    exit_code = INTERNAL_ERROR


class FlexrosNode(AbstractTopicNode):
    """Base of all nodes: a lifecycle node that reads its parameters from data and ends with a report.

    How to add a node: write one file in `nodes` with one subclass and `main`, and `msgs_config/<node>.yaml`.
    It provides:

    1. `node_name`, a class variable: name of the node and of its parameter file.
    2. `configure`: make the core, publishers and subscriptions; raise InputError or RunError if that cannot be.
    3. `start` and `stop`: begin and end to work; timers belong here. Activated again, a node begins anew.
    4. `release`: give back what `configure` opened, beside publishers and subscriptions.
    5. `figures`: what diagnostics and report show.

    A callback given to `listen`, `offer` or `every` may raise a FlexrosError: the node then ends with its exit code.

    Args:
        context: ROS context; the default one if None.
        values: Parameter values that override files and defaults.
    """

    node_name: str

    def __init__(self, *, context: Context | None = None, values: Mapping[str, Value] | None = None) -> None:
        super().__init__(self.node_name, context, values or {})
        refuse_impossible_transitions(self)
        self.report: NodeReport | None = None
        self.on_end: Callable[[FlexrosNode], None] | None = None
        self.tells_errors = True  # False where whoever holds the node says why it ended
        self._end_announced = False
        self.stamp = START_NS
        self._holds = False
        try:
            self.declare(node_parameters(self.node_name))
            self._diagnostics = self.announce("diagnostics")
        except FlexrosError:
            self.destroy_node()  # nobody else has it yet
            raise
        self._made.clear()  # the publisher of diagnostics stays for the node's whole life

    # What a node provides.

    @property
    def paced(self) -> Paced | None:
        """The node itself if whoever spins it has to start its cycles at the times of a schedule."""
        return None

    @abstractmethod
    def configure(self) -> None:
        """Make core, publishers and subscriptions from the parameters."""

    def start(self) -> None:
        """Begin to work."""

    def stop(self) -> None:
        """End to work; called once for every `start`, also after a failure."""

    def release(self) -> None:
        """Give back what `configure` opened; called once for every `configure`, also for one that failed."""

    def refusal(self) -> str:
        """Say why the node cannot be activated now; nothing if it can."""
        return ""

    def partner_ended(self) -> None:
        """Hear that another node of the run has ended before its time."""

    def figures(self) -> dict[str, float]:
        """Give counts and statistics by name."""
        return {}

    def recent_figures(self) -> dict[str, float]:
        """Give the figures for the diagnostics, which may tell of the time since the last ones."""
        return self.figures()

    # Diagnostics and end.

    def _with_unreadable(self, figures: Mapping[str, float]) -> dict[str, float]:
        return {**figures, **({"unreadable_messages": self.unreadable} if self.unreadable else {})}

    def diagnose(
        self,
        level: bytes = DiagnosticStatus.OK,
        message: str = "running",
        recent: Mapping[str, float] | None = None,
    ) -> None:
        """Publish the figures on /diagnostics.

        Args:
            level: DiagnosticStatus.OK, WARN or ERROR.
            message: State of the node in words.
            recent: The figures; default: `recent_figures`.
        """
        figures: Mapping[str, float] = {}
        if self.configured:
            figures = self._with_unreadable(self.recent_figures() if recent is None else recent)
        values = [KeyValue(key=key, value=f"{value:.9g}") for key, value in figures.items()]
        status = DiagnosticStatus(
            level=level, name=self.get_fully_qualified_name(), message=message, hardware_id="flexros", values=values
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp.sec, array.header.stamp.nanosec = divmod(self.stamp, NANOSECONDS)
        with suppress(InvalidHandle):  # the context may be gone when a run is interrupted
            self._diagnostics.publish(array)

    def announce_end(self, error: FlexrosError | None) -> None:
        """Publish the last diagnostics, once.

        Args:
            error: Why the node broke off, None when it is done.
        """
        if not self._end_announced:
            self._end_announced = True
            level = DiagnosticStatus.OK if error is None else DiagnosticStatus.ERROR
            self.diagnose(level, "done" if error is None else str(error))

    def end(self, error: FlexrosError | None = None) -> None:
        """End the node's work once, with a report; the process or the run that holds the node decides what follows.

        Args:
            error: Why it broke off, None when it is done.
        """
        if self.report is not None:
            return
        for close in (self._halt, self._give_back):
            try:
                close()
            except FlexrosError as late:
                error = error or late
        figures = self._with_unreadable(self.figures()) if self.configured else {}
        if error is None:
            self.report = NodeReport(self.node_name, figures=figures)
        else:
            self.report = NodeReport(self.node_name, error.exit_code, str(error), figures)
            if self.tells_errors:
                self.get_logger().error(str(error))
        self.announce_end(error)
        if self.on_end is not None:
            self.on_end(self)

    def _halt(self) -> None:
        if self.active:
            self.active = False
            self._cancel_timers()
            self.stop()

    def _give_back(self) -> None:
        if self._holds:
            self._holds = False
            self.release()

    # Lifecycle.

    def _transition(self, action: Callable[[], None]) -> TransitionCallbackReturn:
        try:
            action()
        except FlexrosError as error:
            self.end(error)
            return TransitionCallbackReturn.FAILURE
        except Exception as error:  # noqa: BLE001 - rclpy would swallow it; it ends the node, with its traceback
            self.get_logger().error(traceback.format_exc())
            self.end(
                NodeFaultError(f"node {self.node_name} has a fault: {type(error).__name__}: {error}; please report it")
            )
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Make what the node needs."""
        self._begin_anew()
        self._holds = True
        result = self._transition(self.configure)
        self.configured = result is TransitionCallbackReturn.SUCCESS
        if not self.configured:
            self._release()
        return result

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to work."""
        if refusal := self.refusal():
            self.get_logger().error(refusal)
            return TransitionCallbackReturn.FAILURE
        self._begin_anew()
        self.active = True
        return self._transition(self.start)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End to work."""
        return self._transition(self._halt)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give back publishers, subscriptions and timers, except those that every node has."""
        return self._transition(self._release)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End to work and leave a report."""
        return self._transition(partial(self.end, None))

    def destroy_node(self) -> None:
        """Give everything back; when the last node of a context is destroyed, its sockets and shared memory go too."""
        super().destroy_node()
        self._state_machine.destroy_when_not_in_use()  # rclpy lets it hold the node until both are garbage collected

    def _begin_anew(self) -> None:
        self.report = None
        self._end_announced = False

    def _release(self) -> None:
        self.configured = False
        self._close_all()
        self._give_back()
