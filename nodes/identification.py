"""Identification node: leads an identification experiment in the place of the feedforward node."""

from __future__ import annotations

from typing import TYPE_CHECKING

from std_msgs.msg import String

from flexros.errors import InputError
from flexros_nodes.protocol.experiment_state import ExperimentCourse, ExperimentState
from flexros_nodes.protocol.reference.reference_rows import RowsToRest
from flexros_nodes.shell.executable import run_node
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.prepared_run import prepared_run
from flexros_nodes.shell.reference_stream import ReferenceStream
from flexros_nodes.shell.topic_interface import period
from flexros_nodes.shell.topic_node import Answer

if TYPE_CHECKING:
    from flexros.scenario.experiment import Experiment

STATE_PERIOD = 0.2
"""Period at which the state goes to plant and recorder [s] (wall clock), chosen: a lost one is soon made up for."""

LEAST_REST = 0.5
"""Shortest time for which the robot stands still after a stop [s], chosen: until oscillations have died away."""


class IdentificationNode(FlexrosNode):
    """Streams the reference of an identification experiment and tells how far it is.

    Its services are of type std_srvs/srv/Trigger, below its name:

    1. `start` begins an experiment that waits (parameter `begin_at_once` is false). While it waits plant and controller
       repeat their first sample: what the node says on experiment_state keeps the plant from giving up.
    2. `stop` brings the robot to rest on its planned way (within the fade time, in a move at its acceleration), leaves
       it at rest for a while and ends the run before its time. That is an end in order, with exit code 0, because the
       user asked for it and everything that was done is in the log; the provenance of the log says that it was
       stopped, at which sample, and how many experiments were complete by then.
    3. `status` gives the state as JSON, see `ExperimentState`.
    """

    node_name = "identification"

    def configure(self) -> None:
        """Compute plan and reference; make publishers, services and the subscription to the clock."""
        self._run: Experiment = prepared_run(self.value("scenario"))
        settings = self._run.scenario.identification
        if self._run.plan is None or settings is None:
            raise InputError(
                f"scenario {self._run.scenario.name} has no key identification, which node identification needs; add "
                "the key, or take node feedforward"
            )
        self._n_rest = round(max(settings.settle, LEAST_REST) / self._run.sample_time)
        self._course = ExperimentCourse(self._run.plan)
        self._stream = ReferenceStream(self, self._run)
        self._stream.on_progress = self._on_progress
        self._stream.on_restart = self._on_restart
        self._states = self.announce("experiment_state")
        self.offer("start", self._on_start)
        self.offer("stop", self._on_stop)
        self.offer("status", self._on_status)
        self._begin()

    def _begin(self) -> None:
        """Stand before the first sample."""
        self._stream.closed = not self.value("begin_at_once")
        self._stopped: tuple[int, int] | None = None
        self._told = -1

    def start(self) -> None:
        """Look for the readers; begin the experiment, or wait for the service."""
        self._begin()
        self._stream.start()
        self.every(period("diagnostics"), self._tell)
        self.every(STATE_PERIOD, self._send_state)

    def state(self) -> ExperimentState:
        """Give the present state of the experiment."""
        progress, last = self._stream.progress, self._run.n_samples - 1
        if self._stopped is not None:
            return self._course.state("stopping", progress, self._stopped)
        if self._stream.closed:
            return self._course.state("waiting", progress)
        return self._course.state("done" if progress + self._stream.clock_samples > last else "running", progress)

    def figures(self) -> dict[str, float]:
        """Give how far the experiment is, and what was sent and sent again."""
        return {**self.state().numbers(), **self._stream.figures()}

    def _on_progress(self, progress: int) -> None:
        """Tell at once when an experiment begins or ends."""
        completed = self._course.n_completed(progress)
        if completed != self._told and self._stopped is None:
            self._told = completed
            self._tell()

    def _on_restart(self) -> None:
        """Follow a plant that was reset: the experiment has not begun."""
        self._begin()
        self._send_state()

    def _tell(self) -> None:
        self.diagnose(message=self.state().sentence())

    def _send_state(self) -> None:
        self._states.publish(String(data=self.state().as_json()))

    # Services.

    def _on_start(self) -> Answer:
        if self._stopped is not None:
            return Answer(False, f"the experiment was stopped ({self.state().sentence()}); run it again")
        if not self._stream.closed:
            return Answer(False, f"the experiment has been started already: {self.state().sentence()}")
        self._stream.open()
        self._tell()
        return Answer(True, f"the experiment begins; it takes {self.state().time_left_s:g} s of simulated time")

    def _on_stop(self) -> Answer:
        if self._stopped is not None:
            return Answer(True, f"the experiment has been stopped already: {self.state().sentence()}")
        first, last = self._stream.sent, self._run.n_samples - 1
        if first > last:
            return Answer(True, f"the experiment ends by itself within {self.state().time_left_s:g} s")
        n_slowing = self._course.n_slowing(first)
        self._stopped = first, min(first + n_slowing + self._n_rest, last)
        self._stream.replace(RowsToRest(self._run.reference, first, n_slowing, self._run.sample_time))
        self._send_state()
        self._stream.open()
        self._tell()
        return Answer(True, f"{self.state().sentence()}; the run ends in {self.state().time_left_s:g} s")

    def _on_status(self) -> Answer:
        return Answer(True, self.state().as_json())


def main() -> int:
    """Run the node as an executable."""
    return run_node(IdentificationNode)


if __name__ == "__main__":
    raise SystemExit(main())
