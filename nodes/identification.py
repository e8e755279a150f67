"""Identification node: conducts an identification experiment in place of the feedforward node."""

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
"""Period at which the state is sent to plant and recorder [s] (wall clock), chosen: a lost one is soon replaced."""

LEAST_REST = 0.5
"""Shortest rest after a stop [s], chosen: until oscillations have decayed."""


class IdentificationNode(FlexrosNode):
    """Streams the reference of an identification experiment and reports its progress.

    Its services have type std_srvs/srv/Trigger, in the namespace of the node:

    1. `start` starts an experiment that waits (parameter `begin_at_once` is false). Meanwhile plant and controller
       repeat their first sample, and the messages on experiment_state keep the plant from aborting.
    2. `stop` brings the robot to rest on its planned path (within the fade time, in a move at its acceleration), keeps
       it at rest for a while and ends the run early. The exit code is 0, because the user requested it and the log is
       complete up to the stop. The provenance of the log states the sample of the stop and the number of experiments
       completed by then.
    3. `status` returns the state as JSON, see `ExperimentState`.
    """

    node_name = "identification"

    def configure(self) -> None:
        """Compute plan and reference; create publishers, services and the subscription to the clock."""
        self.run: Experiment = prepared_run(self.value("scenario"))
        settings = self.run.scenario.identification
        if self.run.plan is None or settings is None:
            raise InputError(
                f"scenario {self.run.scenario.name} has no key identification, which node identification needs; add "
                "the key, or use node feedforward"
            )
        self._n_rest = round(max(settings.settle, LEAST_REST) / self.run.sample_time)
        self._course = ExperimentCourse(self.run.plan)
        self.stream = ReferenceStream(self, self.run)
        self.stream.on_progress = self._on_progress
        self.stream.on_restart = self._on_restart
        self._states = self.announce("experiment_state")
        self.offer("start", self._on_start)
        self.offer("stop", self._on_stop)
        self.offer("status", self._on_status)
        self._begin()

    def _begin(self) -> None:
        """Return to the state before the first sample."""
        self.stream.closed = not self.value("begin_at_once")
        self._stopped: tuple[int, int] | None = None
        self._last_completed = -1

    def start(self) -> None:
        """Search for the subscribers; start the experiment, or wait for the service."""
        self._begin()
        self.stream.start()
        self.every(period("diagnostics"), self._publish_progress)
        self.every(STATE_PERIOD, self._send_state)

    def state(self) -> ExperimentState:
        """Return the present state of the experiment."""
        progress, last = self.stream.progress, self.run.n_samples - 1
        if self._stopped is not None:
            return self._course.state("stopping", progress, self._stopped)
        if self.stream.closed:
            return self._course.state("waiting", progress)
        return self._course.state("done" if progress + self.stream.clock_samples > last else "running", progress)

    def figures(self) -> dict[str, float]:
        """Return the progress of the experiment, and counts of sent and repeated messages."""
        return {**self.state().numbers(), **self.stream.figures()}

    def _on_progress(self, progress: int) -> None:
        """Publish the progress at once when an experiment begins or ends."""
        completed = self._course.n_completed(progress)
        if completed != self._last_completed and self._stopped is None:
            self._last_completed = completed
            self._publish_progress()

    def _on_restart(self) -> None:
        """Restart after a reset of the plant: the experiment has not begun."""
        self._begin()
        self._send_state()

    def _publish_progress(self) -> None:
        self.diagnose(message=self.state().sentence())

    def _send_state(self) -> None:
        self._states.publish(String(data=self.state().as_json()))

    # Services.

    def _on_start(self) -> Answer:
        if self._stopped is not None:
            return Answer(False, f"the experiment was stopped ({self.state().sentence()}); run it again")
        if not self.stream.closed:
            return Answer(False, f"the experiment has been started already: {self.state().sentence()}")
        self.stream.open()
        self._publish_progress()
        return Answer(True, f"the experiment begins; it takes {self.state().time_left_s:g} s of simulated time")

    def _on_stop(self) -> Answer:
        if self._stopped is not None:
            return Answer(True, f"the experiment has been stopped already: {self.state().sentence()}")
        first, last = self.stream.sent, self.run.n_samples - 1
        if first > last:
            return Answer(True, f"the experiment ends by itself within {self.state().time_left_s:g} s")
        n_slowing = self._course.n_slowing(first)
        self._stopped = first, min(first + n_slowing + self._n_rest, last)
        self.stream.replace(RowsToRest(self.run.reference, first, n_slowing, self.run.sample_time))
        self._send_state()
        self.stream.open()
        self._publish_progress()
        return Answer(True, f"{self.state().sentence()}; the run ends in {self.state().time_left_s:g} s")

    def _on_status(self) -> Answer:
        return Answer(True, self.state().as_json())


def main() -> int:
    """Run the node in this process."""
    return run_node(IdentificationNode)


if __name__ == "__main__":
    raise SystemExit(main())
