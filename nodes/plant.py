"""Plant node: publishes measurements of the simulated robot and moves it by the commands that come back."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import FlexrosError, RunError
from flexros.logs.stamps import stamp_ns, stamp_of
from flexros_nodes.breakdown import no_partners_text, partner_ended_text, recorder_silence_text, silence_text
from flexros_nodes.command_reader import CommandReader
from flexros_nodes.ending import Ending
from flexros_nodes.executable import run_node
from flexros_nodes.experiment_state import read_experiment_state
from flexros_nodes.held_command import HeldCommand
from flexros_nodes.lockstep import FASTEST_RESEND, PlantLockStep, Tick
from flexros_nodes.loop_figures import loop_figures, timing_figures
from flexros_nodes.message_loss import MessageLoss
from flexros_nodes.node_base import FlexrosNode
from flexros_nodes.pacing import Schedule
from flexros_nodes.plant_messages import OWN_TOPICS, PlantMessages, read_recorder_progress, recorder_window
from flexros_nodes.plant_view import MARKER_PERIOD, PlantView
from flexros_nodes.prepared_run import prepared_run
from flexros_nodes.topic_interface import period

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros_nodes.pacing import PeriodStatistics

LOOK_PERIOD = 0.01
"""Period at which the plant looks for its partners, and at the end brakes and awaits the recorder [s], chosen."""


class PlantNode(FlexrosNode):
    """The robot of a scenario behind the topics joint_states and joint_commands.

    In lock-step it publishes sample k and goes on when the command of sample k has come. In real time whoever spins the
    node calls `cycle` at the times of `schedule`; then it never waits, holds the last command and counts the miss.

    Attributes:
        prioritised: Whether the thread that paces the node has real-time priority.
        schedule: Due times of a real-time run, None in lock-step and before the handshake is over.
    """

    node_name = "plant"
    prioritised = False
    schedule: Schedule | None = None
    _k = -1
    _ending: Ending | None = None

    def configure(self) -> None:
        """Prepare the robot, publishers and the subscription to commands."""
        self._run = run = prepared_run(self.value("scenario"))
        self._sample_time = run.sample_time
        self._names = run.nominal.joint_names
        self._real_time = bool(self.value("real_time"))
        self._reader = CommandReader(self._names)
        self._messages = PlantMessages(self, self._names, self._sample_time)
        self._view = PlantView(self, run)
        self.listen("joint_commands", self._on_command)
        self.listen("recorder_progress", self._on_recorded)
        self.listen("experiment_state", self._on_experiment)
        self._begin()

    def _begin(self) -> None:
        """Stand before the first sample."""
        self._plant = self._run.plant_in_time()
        self._n_samples = self._run.n_samples
        self.schedule = None
        self._k = -1
        self._newest: HeldCommand | None = None
        self._began = self._ended = 0.0
        self._first: FloatArray | None = None
        self._ending = None
        self._loss = MessageLoss(self.value("drop_fraction"), self.value("drop_seed"))
        self._drops: Callable[[], bool] | None = self._loss.drops if self.value("drop_fraction") else None
        timeouts = (self.value(f"{name}_timeout") for name in ("resend", "partner", "start"))
        self._lockstep = PlantLockStep(FASTEST_RESEND, *timeouts)
        window = self.value("recorder_window") if self.value("observers") else 0
        self._window = recorder_window(window, self._sample_time, self._real_time)

    @property
    def paced(self) -> PlantNode | None:
        """The node itself in real time."""
        return self if self.value("real_time") else None

    def start(self) -> None:
        """Look for the partners; the first state goes out when they are there."""
        if self._k >= 0:
            self._begin()
        self._search_time = 0.0
        self.every(LOOK_PERIOD, self._look_around)
        self.every(FASTEST_RESEND, self._watch)
        self.every(period("diagnostics"), self.diagnose)
        self.every(MARKER_PERIOD, lambda: self._view.show(self._plant))

    def stop(self) -> None:
        """Stop pacing."""
        self.schedule = None

    def figures(self) -> dict[str, float]:
        """Give samples, losses and, in real time, how well the schedule was kept."""
        return self._counts() | self._timing(Schedule.statistics)

    def recent_figures(self) -> dict[str, float]:
        """Give the same with the schedule since the last time: it must not cost more as a run grows long."""
        return self._counts() | self._timing(Schedule.recent_statistics)

    def _counts(self) -> dict[str, float]:
        if self._k < 0:
            return {"samples": 0}
        samples = self._k if self.active and self._ending is None else self._k + 1
        time, wall = samples * self._sample_time, (self._ended or perf_counter()) - self._began
        return loop_figures(time, samples, wall, self._lockstep, self._loss, self._window, self._ending)

    def _timing(self, sum_up: Callable[[Schedule], PeriodStatistics | None]) -> dict[str, float]:
        if not self._real_time:
            return {}
        cycles = None if self._newest is None else sum_up(self._cycles)
        return timing_figures(self.prioritised, self._newest, cycles)

    # Handshake and watch.

    def _look_around(self) -> None:
        if self._ending is not None:
            self._work_towards_end(self._ending)
        if self._k >= 0:
            return
        observers = self.value("observers")
        if self._messages.have_partners(observers):
            self._window.start(stamp_ns(0, self._sample_time))
            self._began = perf_counter()
            self._next_sample()
            return
        self._search_time += LOOK_PERIOD
        if self._search_time > self.value("start_timeout"):
            raise RunError(no_partners_text(self._messages.listeners(), observers, self.value("start_timeout")))

    def _watch(self) -> None:
        if self._k < 0 or self._ending is not None or self.schedule is not None:
            return
        if self._window.held or self._first is not None:
            if self._window.wait(FASTEST_RESEND) > self.value("recorder_timeout"):
                raise RunError(recorder_silence_text(self._window.confirmed, self.value("recorder_timeout")))
            self._go_on()
        if self._window.held:
            return
        tick = self._lockstep.tick()
        if tick is Tick.RESEND:
            self._messages.publish()
        elif tick is Tick.GIVE_UP:
            resends = self._lockstep.resends + self._lockstep.handshakes
            raise RunError(silence_text(self._k, self.stamp, self._lockstep.silence, resends))

    def _on_command(self, message: bytes) -> None:
        if self._ending is not None or (self._drops is not None and self._drops()):
            return
        if not self._lockstep.answers(stamp_of(message)):
            return
        command = self._reader.read(message, self._k)
        if self._newest is not None:
            self._newest.offer(command)
        elif self._k:
            self._advance(command)
        else:
            self._first = command
            self._lockstep.hold()  # while the recorder is awaited; the first sample is repeated until it is heard
            self._go_on()

    def _advance(self, command: FloatArray) -> None:
        if self._k + 1 >= self._n_samples:
            self._finish(None)
            return
        self._plant.advance(command)
        self._next_sample()

    def _next_sample(self) -> None:
        """Measure sample k + 1 and publish it, unless the recorder is too far behind."""
        self._k += 1
        self.stamp = stamp = self._messages.fill(self._k, self._plant.measure(), self._plant.tool_pose())
        self._lockstep.sent(stamp)
        if self._window.admits(stamp):
            self._messages.publish()
        else:
            self._window.hold()

    def _on_recorded(self, message: bytes) -> None:
        self._window.confirm(*read_recorder_progress(message))
        self._go_on()

    def _go_on(self) -> None:
        """Publish the sample that was held back, or go on after the first one, as soon as the recorder permits."""
        if self._window.held and self._window.admits(self.stamp):
            self._window.held = False
            self._lockstep.hold()
            self._messages.publish()
        elif self._first is not None and self._window.has_begun(self._messages.is_published):
            command, self._first = self._first, None
            self._began = perf_counter()
            if self._real_time:
                self._begin_pacing(command)
            else:
                self._advance(command)

    def _on_experiment(self, message: bytes) -> None:
        """Be patient while an experiment waits for its start; end with its last sample when it was stopped."""
        state = read_experiment_state(message)
        if state.state == "waiting":
            self._lockstep.hold()
        self._n_samples = min(self._n_samples, state.last_sample + 1)

    # Real time.

    def _begin_pacing(self, command: FloatArray) -> None:
        self._newest = HeldCommand(command, self._sample_time, self.value("real_time_patience"))
        self._cycles = Schedule(self._sample_time)
        self._cycles.begin(self._began + self._sample_time)
        self.schedule = self._cycles

    @property
    def answered(self) -> bool:
        """Whether the command of the present sample is there; also when no answer is awaited any more."""
        return self._newest is None or self._newest.is_new or self._ending is not None

    def cycle(self) -> None:
        """Do the cycle that is due: move by the newest command, measure, publish. Called by whoever paces the node."""
        if self._newest is None or self._ending is not None:
            return
        try:
            command = self._newest.take()
            if command is None:
                raise RunError(silence_text(self._k, self.stamp, self.value("real_time_patience")))
            self._advance(command)
        except FlexrosError as error:
            self.end(error)

    # End.

    def partner_ended(self) -> None:
        """Brake: whoever started the nodes knows sooner than a time-out that one of them is gone."""
        self.end(RunError(partner_ended_text(self._k, self.stamp)))

    def end(self, error: FlexrosError | None = None) -> None:
        """End as every node; when the run breaks off, brake first and let the recorder hear of it."""
        if self._ending is None and error is not None and self.active and self._k >= 0:
            self._finish(error)
        elif self._ending is None or error is None or not self.active:
            super().end(error or (self._ending.failure if self._ending else None))

    def _finish(self, error: FlexrosError | None) -> None:
        """Stop the loop, brake if it broke off, and wait for the recorder."""
        self._ended = perf_counter()
        self._first = None
        self.schedule = None
        n_brake = 0 if error is None else round(self.value("brake_duration") / self._sample_time)
        self._ending = Ending(error, n_brake)
        if error is not None:
            self._window.follow(OWN_TOPICS)
            self._go_on()
        self._work_towards_end(self._ending)

    def _work_towards_end(self, ending: Ending) -> None:
        """Brake on; then end once everything is recorded: after a failure only what the plant itself has sent."""
        if ending.brakes:
            self._brake(ending)
        else:
            self.announce_end(ending.failure)
            topics = OWN_TOPICS if ending.failure else self._window.by_topic.keys() | set(OWN_TOPICS)
            if not self.value("observers") or self._window.holds(topics, self.stamp):
                super().end(ending.failure)
                return
        if ending.wait(LOOK_PERIOD):
            super().end(ending.failure)

    def _brake(self, ending: Ending) -> None:
        """Simulate on with zero torque, publishing as usual, at the pace of time at most and of the recorder."""
        nothing = np.zeros(len(self._names))
        try:
            for _ in range(max(round(LOOK_PERIOD / self._sample_time), 1)):
                if self._window.held or not ending.brakes:
                    return
                self._plant.advance(nothing)
                self._next_sample()
                ending.brake()
        except RunError:  # a plant that has diverged cannot go on
            ending.give_up_braking()


def main() -> int:
    """Run the node as an executable."""
    return run_node(PlantNode)


if __name__ == "__main__":
    raise SystemExit(main())
