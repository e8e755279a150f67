"""Plant node: publishes measurements of the simulated robot and moves it by the commands that come back."""

from __future__ import annotations

import math
from contextlib import suppress
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from rclpy.duration import Duration
from rosgraph_msgs.msg import Clock as ClockMessage

from flexros.errors import FlexrosError, RunError
from flexros.logs.joint_state_message import JointStateTemplate, JointStateView, stamp_of
from flexros.logs.pose_stamped_message import PoseStampedTemplate
from flexros.logs.stamps import NANOSECONDS, stamp_ns
from flexros_nodes.executable import run_node
from flexros_nodes.lockstep import PlantLockStep, RecorderWindow, Tick
from flexros_nodes.message_loss import MessageLoss
from flexros_nodes.node_base import FlexrosNode
from flexros_nodes.pacing import Schedule
from flexros_nodes.prepared_run import BASE_FRAME, make_plant, prepared_run
from flexros_nodes.topic_interface import topic

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray

FIND_PERIOD = 0.01
"""Period at which the plant looks whether its partners are there [s], chosen."""

DIAGNOSTICS_PERIOD = 1.0
"""Period of the diagnostics [s] (wall clock)."""


class PlantNode(FlexrosNode):
    """The robot of a scenario behind the topics joint_states and joint_commands.

    In lock-step it publishes sample k and goes on when the command of sample k has come. In real time whoever spins the
    node calls `cycle` at the times of `schedule`; then it never waits, holds the last command and counts the miss.

    Attributes:
        schedule: Due times of a real-time run, None in lock-step and before the handshake is over.
    """

    node_name = "plant"
    schedule: Schedule | None = None

    def configure(self) -> None:
        """Prepare the robot, publishers and the subscription to commands."""
        run = prepared_run(self.value("scenario"))
        self._plant = make_plant(run)
        self._n_samples = run.n_samples
        self._sample_time = run.sample_time
        self._names = run.nominal.joint_names
        self._real_time = bool(self.value("real_time"))
        self._state_message = JointStateTemplate(self._names, position=True)
        self._pose_message = PoseStampedTemplate(BASE_FRAME)
        self._view = JointStateView(self._names)
        self._clock_every = max(round(1.0 / ((topic("clock").rate or 1.0) * self._sample_time)), 1)
        self._states = self.announce("joint_states")
        self._poses = self.announce("tool_pose")
        self._clock_publisher = self.announce("clock")
        self.listen("joint_commands", self._on_command)
        self.listen("recorder_progress", self._on_recorded)
        self.schedule = None
        self._reset_counts()

    def _reset_counts(self) -> None:
        self._k = -1
        self._missed = self._missed_in_a_row = self._late_commands = 0
        self._command = np.zeros(len(self._names))
        self._fresh: FloatArray | None = None
        self._began = self._ended = 0.0
        self._braked = 0
        self._held = False
        self._loss = MessageLoss(self.value("drop_fraction"), self.value("drop_seed"))
        self._drops: Callable[[], bool] | None = self._loss.drops if self.value("drop_fraction") else None
        period = self.value("resend_timeout")
        self._lockstep = PlantLockStep(period, self.value("partner_timeout"), self.value("start_timeout"))
        wait_for_recorder = self.value("observers") and not self._real_time
        window = stamp_ns(self.value("recorder_window") if wait_for_recorder else 0, self._sample_time)
        self._window = RecorderWindow(window - stamp_ns(0, self._sample_time))

    @property
    def paced(self) -> bool:
        """Whether the run is in real time."""
        return bool(self.value("real_time"))

    def start(self) -> None:
        """Look for the partners; the first state goes out when they are there."""
        self._search_time = 0.0
        self.every(FIND_PERIOD, self._find_partners)
        self.every(self.value("resend_timeout"), self._watch)
        self.every(DIAGNOSTICS_PERIOD, self.diagnose)

    def stop(self) -> None:
        """Stop pacing."""
        self.schedule = None

    def figures(self) -> dict[str, float]:
        """Give samples, losses and, in real time, how well the schedule was kept."""
        if self._k < 0:
            return {"samples": 0}
        samples = self._k if self.active else self._k + 1
        wall = max((self._ended or perf_counter()) - self._began, 1e-9)
        figures: dict[str, float] = {
            "samples": samples,
            "simulated_time_s": samples * self._sample_time,
            "wall_time_s": wall,
            "samples_per_s": samples / wall,
            "resends": self._lockstep.resends,
            "duplicate_commands": self._lockstep.duplicates,
            "dropped_on_purpose": self._loss.dropped,
            "waits_for_recorder": self._window.waits,
            "braked_samples": self._braked,
        }
        if self._real_time:
            figures |= {"missed_commands": self._missed, "late_commands": self._late_commands}
            statistics = self._timing.statistics() if self._began else None
            figures |= statistics.as_dict() if statistics else {}
        return figures

    # Handshake and watch.

    def _find_partners(self) -> None:
        if self._k >= 0:
            return
        observers = self.value("observers")
        heard = self._states.get_subscription_count() > observers and self._poses.get_subscription_count() >= observers
        if heard and self.count_publishers(topic("joint_commands").name):
            self._window.start(stamp_ns(0, self._sample_time))
            self._began = perf_counter()
            self._timing = Schedule(self._sample_time, self._n_samples)
            self._next_sample()
            return
        self._search_time += FIND_PERIOD
        if self._search_time > self.value("start_timeout"):
            raise RunError(
                f"no partners within {self.value('start_timeout'):g} s: joint_states has "
                f"{self._states.get_subscription_count()} subscriptions, needed are a controller and "
                f"{self.value('observers')} recorders; start them with the same ROS_DOMAIN_ID"
            )

    def _watch(self) -> None:
        if self._k < 0 or self.schedule is not None:
            return
        if self._held:
            self._watch_recorder()
            return
        tick = self._lockstep.tick()
        if tick is Tick.RESEND:
            self._publish()
        elif tick is Tick.GIVE_UP:
            raise RunError(self._silence_text(self._lockstep.silence))

    def _silence_text(self, silence: float) -> str:
        return (
            f"no command for sample {self._k} (stamp {self.stamp / NANOSECONDS:.4f} s) within "
            f"{silence:.3g} s although the state was sent again "
            f"{self._lockstep.resends + self._lockstep.handshakes} times: the controller is gone or lacks its reference; "
            "the plant has braked to zero torque, the log is readable up to there"
        )

    # Lock-step.

    def _on_command(self, message: bytes) -> None:
        if self._drops is not None and self._drops():
            return
        if not self._lockstep.answers(stamp_of(message)):
            return
        command = self._checked(message)
        if self._real_time and self.schedule is not None:
            self._fresh = command
        elif self._real_time:
            self._begin_pacing(command)
        else:
            self._advance(command)

    def _checked(self, message: bytes) -> FloatArray:
        """Read a command, or refuse it."""
        try:
            effort = self._view.unpack(message).effort
        except FlexrosError as error:
            raise self._refusal(str(error)) from error
        if effort is None:
            raise self._refusal("its effort is empty")
        if not math.isfinite(sum(effort)):
            raise self._refusal(f"its effort is {list(effort)}, allowed are finite torques")
        return np.array(effort)

    def _refusal(self, problem: str) -> RunError:
        return RunError(
            f"the command on joint_commands for sample {self._k} (stamp {self.stamp / NANOSECONDS:.4f} s) is refused: "
            f"{problem}; needed is one finite effort for each of {', '.join(self._names)}; the plant has braked to zero "
            "torque, the log is readable up to there"
        )

    def _advance(self, command: FloatArray) -> None:
        if self._k + 1 >= self._n_samples:
            self._ended = perf_counter()
            self._say_goodbye()
            self.end()
            return
        self._plant.advance(command)
        self._next_sample()

    def _next_sample(self) -> None:
        """Measure sample k + 1 and publish it, unless the recorder is too far behind."""
        self._k += 1
        self.stamp = stamp = stamp_ns(self._k, self._sample_time)
        pose = self._plant.tool_pose()
        self._state = self._state_message.fill(stamp, position=self._plant.measure())
        self._pose = self._pose_message.fill(stamp, pose[:3], pose[3:])
        self._lockstep.sent(stamp)
        if self._window.admits(stamp):
            self._publish()
        else:
            self._held = True
            self._recorder_silence = 0.0
            self._window.waits += 1

    def _publish(self) -> None:
        self._states.publish(self._state)
        self._poses.publish(self._pose)
        if self._k % self._clock_every == 0:
            message = ClockMessage()
            message.clock.sec, message.clock.nanosec = divmod(self.stamp, NANOSECONDS)
            self._clock_publisher.publish(message)

    # The recorder sets the pace when it falls behind.

    def _on_recorded(self, message: bytes) -> None:
        self._window.confirm(stamp_of(message))
        if self._held and self._window.admits(self.stamp):
            self._held = False
            self._lockstep.hold()
            self._publish()

    def _watch_recorder(self) -> None:
        self._recorder_silence += self.value("resend_timeout")
        if self._recorder_silence > self.value("partner_timeout"):
            raise RunError(
                f"the recorder has confirmed nothing after stamp {self._window.confirmed / NANOSECONDS:.4f} s for "
                f"{self.value('partner_timeout'):g} s: it is gone; the plant has braked to zero torque, the log is "
                "readable up to there"
            )

    # Real time.

    def _begin_pacing(self, command: FloatArray) -> None:
        self._fresh = command
        self._began = perf_counter()
        self._timing.begin(self._began + self._sample_time)
        self.schedule = self._timing

    def cycle(self) -> None:
        """Do the cycle that is due: move by the newest command, measure, publish. Called by whoever paces the node."""
        try:
            if self._fresh is None:
                self._missed += 1
                self._missed_in_a_row += 1
                if self._missed_in_a_row * self._sample_time > self.value("partner_timeout"):
                    raise RunError(self._silence_text(self.value("partner_timeout")))
            else:
                self._command, self._fresh = self._fresh, None
                self._missed_in_a_row = 0
            self._advance(self._command)
        except FlexrosError as error:
            self.end(error)

    # End.

    def end(self, error: FlexrosError | None = None) -> None:
        """Brake to zero torque when the run broke off, then end as every node."""
        if error is not None and self.report is None and self.configured and self._k >= 0 and not self._braked:
            self._ended = perf_counter()
            self._brake()
        super().end(error)

    def _brake(self) -> None:
        """Simulate on with zero torque, publishing as usual."""
        self._held = False
        self._window = RecorderWindow(0)
        nothing = np.zeros(len(self._names))
        with suppress(RunError):  # a plant that has diverged cannot go on
            for _ in range(round(self.value("brake_duration") / self._sample_time)):
                self._plant.advance(nothing)
                self._next_sample()
                self._braked += 1
        self._say_goodbye()

    def _say_goodbye(self) -> None:
        """Wait until the last messages have reached their readers."""
        for publisher in (self._states, self._poses):
            publisher.wait_for_all_acked(Duration(seconds=1.0))


def main() -> int:
    """Run the node as an executable."""
    return run_node(PlantNode)


if __name__ == "__main__":
    raise SystemExit(main())
