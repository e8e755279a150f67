"""Plant node: publishes measurements of the simulated robot and moves it by the commands that come back."""

from __future__ import annotations

from contextlib import suppress
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import FlexrosError, RunError
from flexros.logs.cdr_cursor import CdrCursor
from flexros.logs.stamps import NANOSECONDS, stamp_ns, stamp_of
from flexros_nodes.command_reader import BRAKED, CommandReader, silence_text
from flexros_nodes.executable import run_node
from flexros_nodes.lockstep import PlantLockStep, RecorderWindow, Tick
from flexros_nodes.message_loss import MessageLoss
from flexros_nodes.node_base import FlexrosNode
from flexros_nodes.pacing import Schedule
from flexros_nodes.plant_messages import OWN_TOPICS, PlantMessages
from flexros_nodes.prepared_run import make_plant, prepared_run
from flexros_nodes.topic_interface import topic

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray

LOOK_PERIOD = 0.01
"""Period at which the plant looks for its partners, and at the end for the recorder's last word [s], chosen."""

GOODBYE_TIMEOUT = 10.0
"""Longest wait at the end for the recorder [s], chosen: a lost message may take seconds to be sent again."""

DIAGNOSTICS_PERIOD = 1.0
"""Period of the diagnostics [s] (wall clock)."""


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

    def configure(self) -> None:
        """Prepare the robot, publishers and the subscription to commands."""
        run = prepared_run(self.value("scenario"))
        self._plant = make_plant(run)
        self._n_samples = run.n_samples
        self._sample_time = run.sample_time
        self._names = run.nominal.joint_names
        self._real_time = bool(self.value("real_time"))
        self._reader = CommandReader(self._names)
        self._messages = PlantMessages(self, self._names, self._sample_time)
        self.listen("joint_commands", self._on_command)
        self.listen("recorder_progress", self._on_recorded)
        self.schedule = None
        self._reset_counts()

    def _reset_counts(self) -> None:
        self._k = -1
        self._missed = self._missed_in_a_row = 0
        self._command = np.zeros(len(self._names))
        self._fresh: FloatArray | None = None
        self._began = self._ended = 0.0
        self._braked = 0
        self._held = False
        self._finishing = False
        self._failure: FlexrosError | None = None
        self._loss = MessageLoss(self.value("drop_fraction"), self.value("drop_seed"))
        self._drops: Callable[[], bool] | None = self._loss.drops if self.value("drop_fraction") else None
        period = self.value("resend_timeout")
        self._lockstep = PlantLockStep(period, self.value("partner_timeout"), self.value("start_timeout"))
        wait_for_recorder = self.value("observers") and not self._real_time
        window = stamp_ns(self.value("recorder_window") if wait_for_recorder else 0, self._sample_time)
        self._window = RecorderWindow(window - stamp_ns(0, self._sample_time))

    @property
    def paced(self) -> PlantNode | None:
        """The node itself in real time."""
        return self if self.value("real_time") else None

    def start(self) -> None:
        """Look for the partners; the first state goes out when they are there."""
        self._search_time = 0.0
        self.every(LOOK_PERIOD, self._look_around)
        self.every(self.value("resend_timeout"), self._watch)
        self.every(DIAGNOSTICS_PERIOD, self.diagnose)

    def stop(self) -> None:
        """Stop pacing."""
        self.schedule = None

    def figures(self) -> dict[str, float]:
        """Give samples, losses and, in real time, how well the schedule was kept."""
        if self._k < 0:
            return {"samples": 0}
        samples = self._k if self.active and not self._finishing else self._k + 1
        wall = max((self._ended or perf_counter()) - self._began, 1e-9)
        figures: dict[str, float] = {
            "samples": samples,
            "simulated_time_s": samples * self._sample_time,
            "wall_time_s": wall,
            "samples_per_s": samples / wall,
            "resends": self._lockstep.resends,
            "stale_commands": self._lockstep.stale,
            "dropped_on_purpose": self._loss.dropped,
            "waits_for_recorder": self._window.waits,
            "braked_samples": self._braked,
        }
        if self._real_time:
            figures |= {"missed_commands": self._missed, "real_time_priority": self.prioritised}
            statistics = self._timing.statistics() if self._began else None
            figures |= statistics.as_dict() if statistics else {}
        return figures

    # Handshake and watch.

    def _look_around(self) -> None:
        if self._finishing:
            self._say_goodbye()
        elif self._k < 0:
            self._find_partners()

    def _find_partners(self) -> None:
        observers = self.value("observers")
        listeners, pose_listeners = self._messages.listeners()
        heard = listeners > observers and pose_listeners >= observers
        if heard and self.count_publishers(topic("joint_commands").name):
            self._window.start(stamp_ns(0, self._sample_time))
            self._began = perf_counter()
            self._timing = Schedule(self._sample_time, self._n_samples)
            self._next_sample()
            return
        self._search_time += LOOK_PERIOD
        if self._search_time > self.value("start_timeout"):
            raise RunError(
                f"no partners within {self.value('start_timeout'):g} s: joint_states has "
                f"{listeners} subscriptions, needed are a controller and "
                f"{self.value('observers')} recorders; start them with the same ROS_DOMAIN_ID"
            )

    def _watch(self) -> None:
        if self._k < 0 or self._finishing or self.schedule is not None:
            return
        if self._held:
            self._watch_recorder()
            return
        tick = self._lockstep.tick()
        if tick is Tick.RESEND:
            self._messages.publish()
        elif tick is Tick.GIVE_UP:
            raise self._silence(self._lockstep.silence)

    def _silence(self, seconds: float) -> RunError:
        resends = self._lockstep.resends + self._lockstep.handshakes
        return RunError(silence_text(self._k, self.stamp, seconds, resends))

    # Lock-step.

    def _on_command(self, message: bytes) -> None:
        if self._finishing or (self._drops is not None and self._drops()):
            return
        if not self._lockstep.answers(stamp_of(message)):
            return
        command = self._reader.read(message, self._k)
        if self._real_time and self.schedule is not None:
            self._fresh = command
        elif self._real_time:
            self._begin_pacing(command)
        else:
            self._advance(command)

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
            self._held = True
            self._recorder_silence = 0.0
            self._window.waits += 1

    # The recorder sets the pace when it falls behind.

    def _on_recorded(self, message: bytes) -> None:
        cursor = CdrCursor(message)
        cursor.skip(8, "stamp")
        self._window.confirm(cursor.string("frame_id"), stamp_of(message))
        if self._held and self._window.admits(self.stamp):
            self._held = False
            self._lockstep.hold()
            self._messages.publish()

    def _watch_recorder(self) -> None:
        self._recorder_silence += self.value("resend_timeout")
        if self._recorder_silence > self.value("recorder_timeout"):
            raise RunError(
                f"the recorder has confirmed nothing after stamp {self._window.confirmed / NANOSECONDS:.4f} s for "
                f"{self.value('recorder_timeout'):g} s: it is gone; {BRAKED}"
            )

    # Real time.

    def _begin_pacing(self, command: FloatArray) -> None:
        self._fresh = command
        self._began = perf_counter()
        self._timing.begin(self._began + self._sample_time)
        self.schedule = self._timing

    @property
    def answered(self) -> bool:
        """Whether the command of the present sample is there; also when no answer is awaited any more."""
        return self._fresh is not None or self._finishing

    def cycle(self) -> None:
        """Do the cycle that is due: move by the newest command, measure, publish. Called by whoever paces the node."""
        if self._finishing:
            return
        try:
            if self._fresh is None:
                self._missed += 1
                self._missed_in_a_row += 1
                if self._missed_in_a_row * self._sample_time > self.value("partner_timeout"):
                    raise self._silence(self.value("partner_timeout"))
            else:
                self._command, self._fresh = self._fresh, None
                self._missed_in_a_row = 0
            self._advance(self._command)
        except FlexrosError as error:
            self.end(error)

    # End.

    def end(self, error: FlexrosError | None = None) -> None:
        """End as every node; when the run breaks off, brake first and let the recorder hear of it."""
        if error is not None and self.active and self._k >= 0 and not self._finishing:
            self._finish(error)
        else:
            super().end(error or (self._failure if self.configured else None))

    def _finish(self, error: FlexrosError | None) -> None:
        """Stop the loop, brake if it broke off, and wait for the recorder."""
        self._ended = perf_counter()
        self._finishing = True
        self._failure = error
        self.schedule = None
        self._goodbye = 0.0
        if error is not None:
            self._brake()
        self.announce_end(error)
        if not self.value("observers"):
            self.end(error)

    def _brake(self) -> None:
        """Simulate on with zero torque, publishing as usual."""
        nothing = np.zeros(len(self._names))
        if self._held:
            self._messages.publish()
        self._window.open()
        with suppress(RunError):  # a plant that has diverged cannot go on
            for _ in range(round(self.value("brake_duration") / self._sample_time)):
                self._plant.advance(nothing)
                self._next_sample()
                self._braked += 1

    def _say_goodbye(self) -> None:
        """End once everything is recorded: after a failure only what the plant itself has sent."""
        topics = OWN_TOPICS if self._failure else self._window.by_topic.keys() | set(OWN_TOPICS)
        self._goodbye += LOOK_PERIOD
        if self._window.holds(topics, self.stamp) or self._goodbye > GOODBYE_TIMEOUT:
            self.end(self._failure)


def main() -> int:
    """Run the node as an executable."""
    return run_node(PlantNode)


if __name__ == "__main__":
    raise SystemExit(main())
