"""Base of all nodes: lifecycle, diagnostics and shutdown."""

from __future__ import annotations

import os
import traceback
from abc import abstractmethod
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import TransitionCallbackReturn

from flexros.errors import INTERNAL_ERROR, FlexrosError
from flexros.logs.stamps import NANOSECONDS, START_NS
from flexros_nodes.protocol.node_report import NodeReport
from flexros_nodes.protocol.parameters import node_parameters
from flexros_nodes.protocol.process.interruption import interruptible
from flexros_nodes.shell.claims import PRODUCERS, TopicClaim, refuse_claims_of_others
from flexros_nodes.shell.topic_node import AbstractTopicNode

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from lifecycle_msgs.srv import ChangeState
    from rclpy.context import Context
    from rclpy.lifecycle import LifecycleNode, LifecycleState

    from flexros_nodes.protocol.parameters import Value
    from flexros_nodes.protocol.real_time.schedule import Paced


class NodeFaultError(FlexrosError):
    """Internal error of a node; the traceback is in its output."""

    exit_code = INTERNAL_ERROR


def refuse_impossible_transitions(node: LifecycleNode) -> None:
    """Answer requests for an impossible lifecycle transition with `success = false`.

    rclpy raises in the service callback, which ends the node. A transition may be requested twice when an answer is
    lost, or by a second `ros2 lifecycle set`.

    Args:
        node: The node, before it is added to an executor.
    """
    service = next(service for service in node.services if service.srv_name.endswith("/change_state"))
    change = service.callback

    def answer(request: ChangeState.Request, response: ChangeState.Response) -> ChangeState.Response:
        try:
            return change(request, response)
        except rclpy_implementation.RCLError as error:
            node.get_logger().warning(f"refused a transition: {error}")
            response.success = False
            return response

    service.callback = answer


class FlexrosNode(AbstractTopicNode):
    """Base of all nodes: lifecycle node that reads its parameters from data and ends with a report.

    How to add a node: write one file in `nodes` with one subclass and `main`, and `msgs_config/<node>.yaml`.
    It provides:

    1. `node_name`, a class variable: name of the node and of its parameter file.
    2. `configure`: create core, publishers and subscriptions; raises InputError or RunError on failure.
    3. `start` and `stop`: activation and deactivation, with timers. A node activated again restarts.
    4. `release`: release what `configure` opened, except publishers and subscriptions.
    5. `figures`: values for diagnostics and report.

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
        self.tells_errors = True  # False where the owner of the node reports why it ended
        self._end_announced = False
        self.stamp = START_NS
        self._to_release = False
        self._claims: list[TopicClaim] = []
        try:
            self.declare(node_parameters(self.node_name))
            self._diagnostics = self.announce("diagnostics")
        except FlexrosError:
            self.destroy_node()  # it has no other owner yet
            raise
        self._resources.clear()  # the publisher of diagnostics remains for the lifetime of the node

    # Overridden by the nodes.

    @property
    def paced(self) -> Paced | None:
        """Cycles that the spinning loop starts at the times of a schedule; None where there are none."""
        return None

    @abstractmethod
    def configure(self) -> None:
        """Create core, publishers and subscriptions from the parameters."""

    def start(self) -> None:
        """Activate."""

    def stop(self) -> None:
        """Deactivate; called once for every `start`, also after a failure."""

    def release(self) -> None:
        """Release what `configure` opened; called once for every `configure`, also after a failure."""

    def refusal(self) -> str:
        """Return why the node cannot be activated now; empty if it can."""
        return ""

    def partner_ended(self) -> None:
        """React to the premature exit of another node of the run."""

    def figures(self) -> dict[str, float]:
        """Return counts and statistics by name."""
        return {}

    def recent_figures(self) -> dict[str, float]:
        """Return the figures for the diagnostics, which may cover only the time since the last message."""
        return self.figures()

    # Claims.

    def claim(self, name: str) -> None:
        """Claim to be the only producer of a topic in this domain and namespace on this machine.

        Args:
            name: Topic, one of `PRODUCERS`.

        Raises:
            InputError: Another node produces it already.
        """
        self._claims.append(
            TopicClaim(self.context.get_domain_id(), self.resolve_topic_name(name), self.value("run"), os.environ)
        )

    def _refuse_other_runs(self) -> None:
        for name in PRODUCERS:
            topic, domain = self.resolve_topic_name(name), self.context.get_domain_id()
            refuse_claims_of_others(domain, topic, self.value("run"), os.environ)

    def _release_claims(self) -> None:
        for claim in self._claims:
            claim.release()
        self._claims.clear()

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
            error: Why the node aborted, None if it is complete.
        """
        if not self._end_announced:
            self._end_announced = True
            level = DiagnosticStatus.OK if error is None else DiagnosticStatus.ERROR
            self.diagnose(level, "done" if error is None else str(error))

    def end(self, error: FlexrosError | None = None) -> None:
        """End the node once, with a report; its process or run decides what follows.

        Args:
            error: Why it aborted, None if it is complete.
        """
        if self.report is not None:
            return
        for close in (self._halt, self._release_once):
            try:
                close()
            except FlexrosError as close_error:
                error = error or close_error
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

    def _release_once(self) -> None:
        if self._to_release:
            self._to_release = False
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
            problem = f"{type(error).__name__}: {error}"
            self.end(NodeFaultError(f"node {self.node_name} has an internal error: {problem}; please report it"))
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Configure the node."""
        self._clear_report()
        self._to_release = True
        try:
            result = self._transition(self._configure)
        except KeyboardInterrupt:  # the loop that spins the node ends with it
            result = TransitionCallbackReturn.FAILURE
        self.configured = result is TransitionCallbackReturn.SUCCESS
        if not self.configured:
            self._release()
        return result

    def _configure(self) -> None:
        with interruptible():  # within the transition: what fails because of a request is no internal error
            self._refuse_other_runs()
            self.configure()

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Activate the node."""
        if refusal := self.refusal():
            self.get_logger().error(refusal)
            return TransitionCallbackReturn.FAILURE
        self._clear_report()
        self.active = True
        return self._transition(self.start)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Deactivate the node."""
        return self._transition(self._halt)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release publishers, subscriptions and services, except those common to all nodes."""
        return self._transition(self._release)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the node with a report."""
        return self._transition(partial(self.end, None))

    def destroy_node(self) -> None:
        """Release everything, also what an active node holds; the last node of a context also releases its sockets."""
        try:
            self._release_once()
        except FlexrosError as error:
            self.get_logger().error(str(error))
        self._release_claims()
        super().destroy_node()
        self._state_machine.destroy_when_not_in_use()  # else it keeps the node until garbage collection

    def _clear_report(self) -> None:
        self.report = None
        self._end_announced = False

    def _release(self) -> None:
        self.configured = False
        self._release_claims()
        self._close_all()
        self._release_once()
