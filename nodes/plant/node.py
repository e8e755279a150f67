"""Plant node: publishes measurements of the simulated robot and applies the received commands."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticStatus

from flexros.errors import FlexrosError, RunError
from flexros_nodes.plant.loop import PlantLoop
from flexros_nodes.plant.services import PlantServices
from flexros_nodes.plant.view import MARKER_PERIOD, PlantView
from flexros_nodes.protocol.loop.abort_messages import BRAKED, missing_partners_message, partner_exited_message
from flexros_nodes.protocol.loop.lockstep import FASTEST_RESEND
from flexros_nodes.protocol.loop.loop_diagnostics import loop_figures, loop_warnings
from flexros_nodes.protocol.loop.pause import Pause
from flexros_nodes.protocol.loop.shutdown import Shutdown
from flexros_nodes.protocol.real_time.plant_pacing import PlantPacing
from flexros_nodes.protocol.real_time.schedule import Schedule
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.partners import RECORDER, WATCH_PERIOD, Partners, strangers_message
from flexros_nodes.shell.prepared_run import prepared_run
from flexros_nodes.shell.topic_interface import period

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rclpy.context import Context

    from flexros_nodes.protocol.parameters import Value
    from flexros_nodes.protocol.real_time.schedule import PeriodStatistics

LOOK_PERIOD = 0.01
"""Period of the search for partners, and at the end of braking and of the wait for the recorder [s], chosen."""


class PlantNode(FlexrosNode):
    """The robot of a scenario behind the topics joint_states and joint_commands.

    `PlantLoop` advances it, `PlantPacing` paces it in real time, and `PlantServices` offer start, pause, step and
    reset. The node itself finds the partners of the loop and shuts it down.
    """

    node_name = "plant"
    _shutdown: Shutdown | None = None

    def __init__(self, *, context: Context | None = None, values: Mapping[str, Value] | None = None) -> None:
        super().__init__(context=context, values=values)
        self._pacing = PlantPacing(lambda command: self.loop.on_cycle(command), lambda: self.loop.receive())

    def configure(self) -> None:
        """Prepare the robot, publishers, services and the subscription to commands."""
        self.claim("joint_states")
        run = prepared_run(self.value("scenario"))
        self._sample_time = run.sample_time
        self.loop = PlantLoop(self, run, self._pacing, self._on_loop_end)
        self.view = PlantView(self, run)
        self._shutdown, self._search_time = None, 0.0
        self._partners = Partners(self)
        self._recorders, self._n_recorders = frozenset[bytes](), 0
        self._surplus = ""
        self._last_figures: dict[str, float] = {}
        PlantServices(self, self.loop, self.reset)

    def reset(self) -> None:
        """Return to the state before the first sample, and search for the partners."""
        self.loop.begin()
        self._shutdown, self._search_time = None, 0.0

    @property
    def paced(self) -> PlantPacing | None:
        """Cycles to be paced in real time; None in lock-step."""
        return self._pacing if self.value("real_time") else None

    def start(self) -> None:
        """Search for the partners; the first state is sent once they are connected."""
        self._recorders, self._n_recorders = frozenset(), 0
        if self.loop.sample >= 0:
            self.reset()
        self._search_time = 0.0
        self.loop.pause = Pause(not self.value("begin_at_once"), perf_counter())
        self.every(LOOK_PERIOD, self._look_around)
        self.every(WATCH_PERIOD, self._watch_partners)
        self.every(FASTEST_RESEND, self.loop.watch)
        self.every(period("diagnostics"), self._send_diagnostics)
        self.every(MARKER_PERIOD, lambda: self.view.show(self.loop.plant))

    def stop(self) -> None:
        """Stop pacing."""
        self._pacing.halt()

    def figures(self) -> dict[str, float]:
        """Return samples, losses and, in real time, the timing of the schedule."""
        return self._counts() | self._timing(Schedule.statistics)

    def recent_figures(self) -> dict[str, float]:
        """Return the same with the timing since the last call, whose cost does not grow with the run."""
        return self._counts() | self._timing(Schedule.recent_statistics)

    def _counts(self) -> dict[str, float]:
        loop = self.loop
        if loop.sample < 0:
            return {"samples": 0}
        samples, time, wall = loop.times(self.active)
        counts = loop_figures(time, samples, wall, loop.lockstep, loop.loss, loop.window, self._shutdown)
        return counts | loop.torque_use.figures()

    def _timing(self, statistics_of: Callable[[Schedule], PeriodStatistics | None]) -> dict[str, float]:
        return self._pacing.figures(statistics_of) if self.value("real_time") else {}

    def _send_diagnostics(self) -> None:
        state, figures = "paused" if self.loop.pause.on else "running", self.recent_figures()
        warnings = loop_warnings(figures, self._last_figures, self.loop.messages.controllers())
        self._last_figures = figures
        level = DiagnosticStatus.WARN if warnings else DiagnosticStatus.OK
        self.diagnose(level, "; ".join([state, *warnings]), figures)

    def _look_around(self) -> None:
        """Search for the partners before the first sample; continue the shutdown after the last one."""
        if self._shutdown is not None:
            self._continue_shutdown(self._shutdown)
        if self.loop.sample >= 0:
            return
        observers, messages = self.value("observers"), self.loop.messages
        if messages.have_partners(observers) and not self._strangers():
            self._note_recorders()
            self.view.look_again()  # a recorder in another process was not connected before
            self.loop.send_first()
            return
        self._search_time = 0.0 if self.loop.pause.on else self._search_time + LOOK_PERIOD
        if self._search_time > self.value("start_timeout"):
            if self._surplus:
                raise RunError(strangers_message(self._surplus))
            raise RunError(missing_partners_message(messages.listeners(), observers, self.value("start_timeout")))

    def _strangers(self) -> str:
        """Return who is there more than once; before the first sample the plant waits until they have left."""
        surplus, before = self._partners.surplus(), self._surplus
        self._surplus = surplus
        if surplus and not before:
            self.get_logger().warning(f"{strangers_message(surplus)}; the plant waits for their end")
        return surplus

    def _watch_partners(self) -> None:
        """Abort where a second plant, controller or reference stream has joined the loop; remember the recorders."""
        if self.loop.sample < 0 or self.loop.over:
            return
        self._note_recorders()
        if surplus := self._partners.surplus():
            raise RunError(f"{strangers_message(surplus)}; {BRAKED}")

    def _note_recorders(self) -> None:
        if (number := self._partners.publishers(RECORDER)) != self._n_recorders:
            self._n_recorders = number
            self._recorders |= self._partners.recorders()

    def refusal(self) -> str:
        """Refuse to begin again while a recorder of the run before is connected: its log holds one run."""
        if not self._recorders & self._partners.recorders():
            return ""
        return (
            f"the plant is at sample {self.loop.sample} and a recorder is connected, whose log cannot return to the "
            "first sample; end the recorder, or clean it up and configure it with another folder"
        )

    # End.

    def partner_ended(self) -> None:
        """Abort: the parent process notices the exit of a node sooner than a time-out."""
        sample = self.loop.sample if self.configured else -1
        self.end(RunError(partner_exited_message(sample, self.stamp)))

    def end(self, error: FlexrosError | None = None) -> None:
        """End as every node does; when the run is aborted, brake first and let the recorder store it."""
        if self._shutdown is None and error is not None and self.active and self.loop.sample >= 0:
            self._finish(error)
        elif self._shutdown is None or error is None or not self.active:
            super().end(error or (self._shutdown.failure if self._shutdown else None))

    def _on_loop_end(self, error: FlexrosError | None) -> None:
        if error is None:
            self._finish(None)
        else:
            self.end(error)

    def _finish(self, error: FlexrosError | None) -> None:
        """Stop the loop, brake if it was aborted, and wait for the recorder."""
        self.loop.end()
        n_brake = 0 if error is None else round(self.value("brake_duration") / self._sample_time)
        self._shutdown = Shutdown(error, n_brake)
        if error is not None:
            self.loop.window.follow(self.loop.messages.own_topics)
            self.loop.go_on()
        self._continue_shutdown(self._shutdown)

    def _continue_shutdown(self, shutdown: Shutdown) -> None:
        """Brake, then end once everything is recorded; after a failure only the topics of the plant itself count."""
        if shutdown.braking:
            self._brake(shutdown)
        else:
            self.announce_end(shutdown.failure)
            window, own = self.loop.window, self.loop.messages.own_topics
            topics = own if shutdown.failure else window.by_topic.keys() | set(own)
            if not self.value("observers") or window.holds(topics, self.loop.stamp):
                super().end(shutdown.failure)
                return
            if shutdown.failure is None:  # the reference follows the clock, and may have missed the last messages of it
                self.loop.messages.publish_time(self.loop.stamp)
        if shutdown.timed_out(LOOK_PERIOD):
            super().end(shutdown.failure)

    def _brake(self, shutdown: Shutdown) -> None:
        """Continue with zero torque, publishing as usual, no faster than real time and than the recorder."""
        try:
            for _ in range(max(round(LOOK_PERIOD / self._sample_time), 1)):
                if not shutdown.braking or not self.loop.brake():
                    return
                shutdown.count_brake_sample()
        except RunError:  # a diverged plant cannot be advanced
            shutdown.stop_braking()
