"""Plant node: publishes measurements of the simulated robot and moves it by the commands that come back."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticStatus

from flexros.errors import FlexrosError, RunError
from flexros_nodes.plant.loop import PlantLoop
from flexros_nodes.plant.messages import OWN_TOPICS
from flexros_nodes.plant.services import PlantServices
from flexros_nodes.plant.view import MARKER_PERIOD, PlantView
from flexros_nodes.protocol.loop.abort_messages import no_partners_text, partner_ended_text
from flexros_nodes.protocol.loop.lockstep import FASTEST_RESEND
from flexros_nodes.protocol.loop.loop_figures import loop_figures
from flexros_nodes.protocol.loop.loop_warnings import loop_warnings
from flexros_nodes.protocol.loop.pause import Pause
from flexros_nodes.protocol.loop.shutdown import Ending
from flexros_nodes.protocol.real_time.plant_pacing import PlantPacing
from flexros_nodes.protocol.real_time.schedule import Schedule
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.prepared_run import prepared_run
from flexros_nodes.shell.topic_interface import period

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rclpy.context import Context

    from flexros_nodes.protocol.parameters import Value
    from flexros_nodes.protocol.real_time.schedule import PeriodStatistics

LOOK_PERIOD = 0.01
"""Period at which the plant looks for its partners, and at the end brakes and awaits the recorder [s], chosen."""


class PlantNode(FlexrosNode):
    """The robot of a scenario behind the topics joint_states and joint_commands.

    `PlantLoop` moves it, `PlantPacing` makes it keep time where it has to, `PlantServices` let its user start, pause,
    step and reset it. The node finds the partners of the loop, and brings it to its end.
    """

    node_name = "plant"
    _ending: Ending | None = None

    def __init__(self, *, context: Context | None = None, values: Mapping[str, Value] | None = None) -> None:
        super().__init__(context=context, values=values)
        self._pacing = PlantPacing(lambda command: self.loop.on_cycle(command), lambda: self.loop.receive())

    def configure(self) -> None:
        """Prepare the robot, publishers, services and the subscription to commands."""
        run = prepared_run(self.value("scenario"))
        self._sample_time = run.sample_time
        self.loop = PlantLoop(self, run, self._pacing, self._on_loop_end)
        self._view = PlantView(self, run)
        self._ending, self._search_time = None, 0.0
        self._told: dict[str, float] = {}
        PlantServices(self)

    def reset(self) -> None:
        """Stand before the first sample, and look for the partners."""
        self.loop.begin()
        self._ending, self._search_time = None, 0.0

    @property
    def paced(self) -> PlantPacing | None:
        """What has to be paced in real time."""
        return self._pacing if self.value("real_time") else None

    def start(self) -> None:
        """Look for the partners; the first state goes out when they are there."""
        if self.loop.sample >= 0:
            self.reset()
        self._search_time = 0.0
        self.loop.pause = Pause(not self.value("begin_at_once"), perf_counter())
        self.every(LOOK_PERIOD, self._look_around)
        self.every(FASTEST_RESEND, self.loop.watch)
        self.every(period("diagnostics"), self._tell)
        self.every(MARKER_PERIOD, lambda: self._view.show(self.loop.plant))

    def stop(self) -> None:
        """Stop pacing."""
        self._pacing.halt()

    def figures(self) -> dict[str, float]:
        """Give samples, losses and, in real time, how well the schedule was kept."""
        return self._counts() | self._timing(Schedule.statistics)

    def recent_figures(self) -> dict[str, float]:
        """Give the same with the schedule since the last time: it must not cost more as a run grows long."""
        return self._counts() | self._timing(Schedule.recent_statistics)

    def _counts(self) -> dict[str, float]:
        loop = self.loop
        if loop.sample < 0:
            return {"samples": 0}
        samples, time, wall = loop.times(self.active)
        counts = loop_figures(time, samples, wall, loop.lockstep, loop.loss, loop.window, self._ending)
        return counts | loop.torque_use.figures()

    def _timing(self, sum_up: Callable[[Schedule], PeriodStatistics | None]) -> dict[str, float]:
        return self._pacing.figures(sum_up) if self.value("real_time") else {}

    def _tell(self) -> None:
        state, figures = "paused" if self.loop.pause.on else "running", self.recent_figures()
        warnings = loop_warnings(figures, self._told, self.loop.messages.controllers())
        self._told = figures
        level = DiagnosticStatus.WARN if warnings else DiagnosticStatus.OK
        self.diagnose(level, "; ".join([state, *warnings]), figures)

    def _look_around(self) -> None:
        """Look for the partners before the first sample; see to the end after the last one."""
        if self._ending is not None:
            self._work_towards_end(self._ending)
        if self.loop.sample >= 0:
            return
        observers, messages = self.value("observers"), self.loop.messages
        if messages.have_partners(observers):
            self.loop.send_first()
            return
        self._search_time = 0.0 if self.loop.pause.on else self._search_time + LOOK_PERIOD
        if self._search_time > self.value("start_timeout"):
            raise RunError(no_partners_text(messages.listeners(), observers, self.value("start_timeout")))

    # End.

    def partner_ended(self) -> None:
        """Brake: whoever started the nodes knows sooner than a time-out that one of them is gone."""
        sample = self.loop.sample if self.configured else -1
        self.end(RunError(partner_ended_text(sample, self.stamp)))

    def end(self, error: FlexrosError | None = None) -> None:
        """End as every node; when the run breaks off, brake first and let the recorder hear of it."""
        if self._ending is None and error is not None and self.active and self.loop.sample >= 0:
            self._finish(error)
        elif self._ending is None or error is None or not self.active:
            super().end(error or (self._ending.failure if self._ending else None))

    def _on_loop_end(self, error: FlexrosError | None) -> None:
        if error is None:
            self._finish(None)
        else:
            self.end(error)

    def _finish(self, error: FlexrosError | None) -> None:
        """Stop the loop, brake if it broke off, and wait for the recorder."""
        self.loop.end()
        n_brake = 0 if error is None else round(self.value("brake_duration") / self._sample_time)
        self._ending = Ending(error, n_brake)
        if error is not None:
            self.loop.window.follow(OWN_TOPICS)
            self.loop.go_on()
        self._work_towards_end(self._ending)

    def _work_towards_end(self, ending: Ending) -> None:
        """Brake on; then end once everything is recorded: after a failure only what the plant itself has sent."""
        if ending.brakes:
            self._brake(ending)
        else:
            self.announce_end(ending.failure)
            window = self.loop.window
            topics = OWN_TOPICS if ending.failure else window.by_topic.keys() | set(OWN_TOPICS)
            if not self.value("observers") or window.holds(topics, self.loop.stamp):
                super().end(ending.failure)
                return
        if ending.wait(LOOK_PERIOD):
            super().end(ending.failure)

    def _brake(self, ending: Ending) -> None:
        """Simulate on with zero torque, publishing as usual, at the pace of time at most and of the recorder."""
        try:
            for _ in range(max(round(LOOK_PERIOD / self._sample_time), 1)):
                if not ending.brakes or not self.loop.brake():
                    return
                ending.brake()
        except RunError:  # a plant that has diverged cannot go on
            ending.give_up_braking()
