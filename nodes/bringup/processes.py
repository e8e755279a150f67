"""Layout processes: one process per node, controlled by the lifecycle services."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import rclpy
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.context import Context
from rclpy.node import Node

from flexros.errors import RunError
from flexros_nodes.bringup.node_process import NodeProcess
from flexros_nodes.bringup.run_plan import SHUTDOWN_TIMEOUT, RunSummary, summarise
from flexros_nodes.protocol.loop.shutdown import FLUSH_TIMEOUT
from flexros_nodes.protocol.parameters import node_parameters
from flexros_nodes.protocol.process.clock_steps import waking_at_clock_steps
from flexros_nodes.shell.domain import DOMAIN_VARIABLE
from flexros_nodes.shell.exposure import check_exposure
from flexros_nodes.shell.removal import await_departures, limited_removal
from flexros_nodes.shell.shared_memory import remove_segments_without_owner
from flexros_nodes.shell.spinning import make_executor

if TYPE_CHECKING:
    from collections.abc import Callable

    from rclpy.client import Client
    from rclpy.task import Future

    from flexros_nodes.bringup.run_plan import RunPlan
    from flexros_nodes.protocol.process.interruption import Interruption

CONFIGURE_TIMEOUT = 60.0
"""Longest time for a node to start and prepare its part of the scenario [s], chosen."""

START_TIMEOUT = 10.0
"""Time after which a process without services is restarted once [s], chosen: discovery takes about one second."""

BRAKING_MARGIN = 2.0
"""Factor on braking duration plus one second, gives the longest time that the plant may take to brake; chosen."""

ANSWER_TIMEOUT = 2.0
"""Time after which a request to a lifecycle service is repeated [s], chosen."""

_STATES = {
    Transition.TRANSITION_CONFIGURE: (State.PRIMARY_STATE_UNCONFIGURED, State.PRIMARY_STATE_INACTIVE),
    Transition.TRANSITION_ACTIVATE: (State.PRIMARY_STATE_INACTIVE, State.PRIMARY_STATE_ACTIVE),
}
"""State before and after a transition."""

SLICE = 0.05
"""Period at which the processes are checked [s]."""


class ProcessManager:
    """Brings up, supervises and shuts down the nodes of a plan.

    Args:
        plan: What to run.
        scratch: Folder for parameter files and reports.
        interrupted: Returns whether termination was requested.
    """

    def __init__(self, plan: RunPlan, scratch: Path, interrupted: Interruption) -> None:
        self._plan = plan
        self._scratch = scratch
        self._interrupted = interrupted
        self._has_killed = False
        self._context = Context()
        rclpy.init(context=self._context, args=[], domain_id=int(os.environ[DOMAIN_VARIABLE]))
        self._node = Node(f"flexros_run_{os.getpid()}", context=self._context, start_parameter_services=False)
        self._executor = make_executor(self._context)
        self._executor.add_node(self._node)
        self._changers = {name: self._node.create_client(ChangeState, f"/{name}/change_state") for name in plan.nodes}
        self._watchers = {name: self._node.create_client(GetState, f"/{name}/get_state") for name in plan.nodes}
        self.processes = {name: NodeProcess(name, plan.process_values(name), scratch) for name in plan.nodes}

    def run(self) -> None:
        """Bring all nodes up and wait for the end of the run."""
        check_exposure(os.environ, int(os.environ[DOMAIN_VARIABLE]))
        with waking_at_clock_steps(self._executor.wake):
            self._bring_up_and_watch()

    def _bring_up_and_watch(self) -> None:
        for name in self._plan.nodes:
            self.await_services(name)
        for transition in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
            for name in self._plan.nodes:
                if not self.change_state(name, transition, CONFIGURE_TIMEOUT):
                    return
        self.wait(lambda: any(process.ended for process in self.processes.values()), None)
        plant = self.processes["plant"]
        recorder = self.processes.get("recorder")
        if not self._interrupted() and (recorder is None or not recorder.ended):
            plant.report_partner_ended()
            self.wait(lambda: plant.ended, self._braking_timeout())

    def _braking_timeout(self) -> float:
        """Return the longest time that the plant may take to brake and to wait for the recorder [s]."""
        default = node_parameters("plant")["brake_duration"].default
        braking = float(self._plan.parameters.get("plant", {}).get("brake_duration", default))
        return BRAKING_MARGIN * (braking + 1.0) + FLUSH_TIMEOUT

    def await_services(self, name: str) -> None:
        """Wait until a node offers its services; restart it once if it does not."""
        clients = (self._changers[name], self._watchers[name])

        def ready() -> bool:
            return self.processes[name].ended or all(client.service_is_ready() for client in clients)

        is_ready = self.wait(ready, START_TIMEOUT)
        if not is_ready and not self._interrupted():
            self.processes[name].stop(SHUTDOWN_TIMEOUT)  # if killed at once, the others would count it for long
            self._has_killed |= self.processes[name].killed
            self.processes[name] = NodeProcess(name, self._plan.process_values(name), self._scratch)

    def change_state(self, name: str, transition: int, timeout: float) -> bool:
        """Request a transition; return False when it was refused, the node ended or termination was requested.

        An answer is lost when the service discovers the request channel of the client before its reply channel. Without
        an answer the state of the node is queried, and the request is repeated if it had not arrived.
        """
        process = self.processes[name]
        origin, target = _STATES[transition]
        request = ChangeState.Request()
        request.transition.id = transition
        deadline = monotonic() + timeout
        answer = self.request(name, self._changers[name], request, deadline)
        while answer is not None and monotonic() < deadline:
            self._wait_for_answer(name, answer)
            if process.ended or self._interrupted():
                return False
            state = target if answer.done() and answer.result().success else self._state(name, deadline)
            if state == target:
                return True
            if state == origin:  # it failed and ends with its reason, or the request was lost
                self.wait(lambda: process.ended, SLICE)
                answer = self.request(name, self._changers[name], request, deadline)
        if process.ended or self._interrupted():
            return False
        raise RunError(f"node {name} did not finish a transition within {timeout:g} s; try again")

    def request(self, name: str, client: Client, request: object, deadline: float) -> Future | None:
        """Send a request once the service is available; None when the node ended or termination was requested."""
        process = self.processes[name]
        self.wait(lambda: client.service_is_ready() or process.ended, deadline - monotonic())
        if process.ended or self._interrupted():
            return None
        if not client.service_is_ready():
            raise RunError(f"the process of node {name} does not offer its services; try again")
        return client.call_async(request)

    def _state(self, name: str, deadline: float) -> int | None:
        """Query the lifecycle state of a node; None when it does not answer."""
        answer = self.request(name, self._watchers[name], GetState.Request(), deadline)
        if answer is None:
            return None
        self._wait_for_answer(name, answer)
        return answer.result().current_state.id if answer.done() else None

    def _wait_for_answer(self, name: str, answer: Future) -> None:
        self.wait(lambda: answer.done() or self.processes[name].ended, ANSWER_TIMEOUT)

    def wait(self, condition: Callable[[], bool], timeout: float | None) -> bool:
        """Spin until a condition holds, a time-out or a termination request; return whether it holds."""
        deadline = None if timeout is None else monotonic() + timeout
        while not condition():
            if self._interrupted() or (deadline is not None and monotonic() > deadline):
                return condition()
            self._executor.spin_once(timeout_sec=SLICE)
        return True

    def close(self) -> None:
        """Shut the nodes down in order, the recorder last, and release all resources."""
        for name in reversed(self._plan.nodes[1:]):
            self.processes[name].request_stop()
        for name in reversed(self._plan.nodes):
            self.processes[name].stop(SHUTDOWN_TIMEOUT)
        await_departures(self._node, self.processes)
        with limited_removal():
            self._executor.shutdown()
            self._node.destroy_node()
            rclpy.try_shutdown(context=self._context)
        if self._has_killed or any(process.killed for process in self.processes.values()):
            remove_segments_without_owner()


def run_processes(plan: RunPlan, interrupted: Interruption) -> RunSummary:
    """Run each node of a plan in its own process.

    Args:
        plan: What to run.
        interrupted: Returns whether termination was requested.

    Returns:
        Summary of the run.

    Raises:
        RunError: A process did not start.
    """
    with tempfile.TemporaryDirectory(prefix="flexros_") as scratch:
        manager = ProcessManager(plan, Path(scratch), interrupted)
        try:
            manager.run()
        finally:
            manager.close()
        reports = {
            name: report for name, process in manager.processes.items() if (report := process.report()) is not None
        }
        deaths = tuple(text for process in manager.processes.values() if (text := process.death()))
        return summarise(reports, plan.folder, "processes", interrupted=interrupted(), deaths=deaths)
