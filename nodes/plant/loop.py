"""Loop of the plant from command to measurement: lock-step, real time or paused."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import FlexrosError, RunError
from flexros.logs.stamps import stamp_ns
from flexros_nodes.plant.messages import PlantMessages, read_recorder_progress, recorder_window
from flexros_nodes.protocol.experiment_state import read_experiment_state
from flexros_nodes.protocol.loop.abort_messages import controller_timeout_message, recorder_timeout_message
from flexros_nodes.protocol.loop.command_reader import CommandReader
from flexros_nodes.protocol.loop.lockstep import FASTEST_RESEND, PlantLockStep, Tick
from flexros_nodes.protocol.loop.message_loss import MessageLoss
from flexros_nodes.protocol.loop.pause import Pause
from flexros_nodes.protocol.loop.torque_use import TorqueUse

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.scenario.experiment import Experiment
    from flexros_nodes.protocol.real_time.plant_pacing import PlantPacing
    from flexros_nodes.shell.node_base import FlexrosNode


class PlantLoop:
    """Publishes sample k and advances on the command of sample k; in real time with the cycles of a schedule.

    Args:
        node: The plant node, for its parameters and messages.
        run: The run.
        pacing: Calls `on_cycle` in real time.
        on_end: Called when the loop ends, with the error if it is aborted.

    Attributes:
        sample: Present sample k; -1 before the first.
        stamp: Its stamp [ns].
        plant: The robot.
        pause: Pause by the user.
        window: Flow control between loop and recorder.
        lockstep: Awaited stamp and repeated states.
        loss: Counts messages dropped on purpose.
        torque_use: Counts the commands at the limits of the motors.
        over: Whether the loop has ended.
    """

    def __init__(
        self, node: FlexrosNode, run: Experiment, pacing: PlantPacing, on_end: Callable[[FlexrosError | None], None]
    ) -> None:
        self._node = node
        self._run = run
        self._pacing = pacing
        self._on_end = on_end
        self._sample_time = run.sample_time
        self._real_time = bool(node.value("real_time"))
        self.messages = PlantMessages(node, run)
        self.pause = Pause(False, 0.0)
        self._commands = node.listen("joint_commands", self._on_command)
        node.listen("recorder_progress", self._on_recorded)
        node.listen("experiment_state", self._on_experiment)
        self.begin()

    def begin(self) -> None:
        """Return to the state before the first sample."""
        value = self._node.value
        self.plant = self._run.plant_in_time()
        self._n_samples = self._run.n_samples
        self._pacing.reset()
        self._node.poll(self._commands, polled=False)
        self._newest_command = -1
        self.sample, self.stamp = -1, stamp_ns(0, self._sample_time)
        self._began = self._ended = 0.0
        self._kept: FloatArray | None = None
        self.over = False
        self._reader = CommandReader(self._run.nominal.joint_names, self.messages.controllers)
        self.loss = MessageLoss(value("drop_fraction"), value("drop_seed"))
        self._drops: Callable[[], bool] | None = self.loss.drops if value("drop_fraction") else None
        self.torque_use = TorqueUse(self._run.nominal.joint_names, self._run.nominal.torque_limits)
        timeouts = (value(f"{name}_timeout") for name in ("resend", "partner", "start"))
        self.lockstep = PlantLockStep(FASTEST_RESEND, *timeouts)
        self.window = recorder_window(
            value("recorder_window") if value("observers") else 0,
            self._sample_time,
            self._real_time,
            self.messages.own_topics,
        )

    def send_first(self) -> None:
        """Send the first sample; all partners are connected."""
        self.window.start(stamp_ns(0, self._sample_time))
        self._began = perf_counter()
        self.next_sample()

    def end(self) -> None:
        """End the loop; `brake` can still append samples."""
        self.over = True
        self._ended = self._now()
        self._kept = None
        self._pacing.halt()

    def times(self, active: bool) -> tuple[int, float, float]:
        """Return the number of samples, the simulated time they cover [s] and the wall-clock time they took [s].

        Args:
            active: Whether the present sample is still in progress, and so not counted.
        """
        samples = self.sample if active and not self.over else self.sample + 1
        return samples, samples * self._sample_time, (self._ended or self._now()) - self._began

    def _now(self) -> float:
        return self.pause.since if self.pause.on else perf_counter()

    def watch(self) -> None:
        """Repeat the present sample, or abort, when its command is overdue; call every FASTEST_RESEND."""
        if self.sample < 0 or self.over or self._pacing.schedule is not None:
            return
        if self.pause.holds:
            self.lockstep.hold()
            return
        if self.window.held or self._kept is not None:
            timeout = self._node.value("recorder_timeout")
            if self.window.wait(FASTEST_RESEND) > timeout:
                raise RunError(recorder_timeout_message(self.window.confirmed, timeout))
            self.go_on()
        if self.window.held:
            return
        tick = self.lockstep.tick()
        if tick is Tick.RESEND:
            self.messages.publish()
        elif tick is Tick.GIVE_UP:
            resends = self.lockstep.resends + self.lockstep.handshakes
            raise RunError(controller_timeout_message(self.sample, self.stamp, self.lockstep.silence, resends))

    def _on_command(self, message: bytes) -> None:
        if self.over or (self._drops is not None and self._drops()):
            return
        stamp = self._reader.stamp(message)
        answers = self.lockstep.answers(stamp)
        if self._real_time and self._pacing.has_begun:
            if self._newest_command < stamp <= self.lockstep.awaited:
                self._newest_command = stamp
                self._pacing.offer(self._reader.read(message, self.sample), late=not answers)
            return
        if not answers:
            return
        command = self._reader.read(message, self.sample)
        if self.sample and not self.pause.on:
            self._advance(command)
        else:
            self._kept = command if self._kept is None else self._kept
            self.lockstep.hold()  # while waiting for the recorder; the first sample is repeated until it is received
            self.go_on()

    def _advance(self, command: FloatArray) -> None:
        if self.sample + 1 >= self._n_samples:
            self._on_end(None)
            return
        self.torque_use.add(command)
        self.plant.advance(command)
        self.next_sample()

    def next_sample(self) -> None:
        """Measure sample k + 1 and publish it, unless the recorder is too far behind."""
        self.sample += 1
        stamp = self.messages.fill(self.sample, self.plant.measure(), self.plant.tool_pose(), self.plant.further())
        self._node.stamp = self.stamp = stamp
        self.lockstep.sent(stamp)
        if self.window.admits(stamp):
            self.messages.publish()
        else:
            self.window.hold()

    def go_on(self) -> None:
        """Publish the sample held back, or advance with the command kept, as soon as that is permitted."""
        if self.window.held and self.window.admits(self.stamp):
            self.window.held = False
            self.lockstep.hold()
            self.messages.publish()
        elif self._kept is not None and not self.pause.holds:
            timeout = self._node.value("recorder_timeout")
            if self.sample == 0 and not self.window.has_begun(self.messages.is_published, timeout):
                return
            command, self._kept = self._kept, None
            now = perf_counter()
            self._began += self.pause.passed(now)
            if self.sample == 0:
                self._began = now
            if self._real_time:
                self._begin_pacing(command, now)
            else:
                self._advance(command)

    def brake(self) -> bool:
        """Advance one sample with zero torque, unless the recorder is too far behind; return whether it did."""
        if self.window.held:
            return False
        self.plant.advance(np.zeros(self._run.nominal.n_motors))
        self.next_sample()
        return True

    def _on_recorded(self, message: bytes) -> None:
        self.window.confirm(*read_recorder_progress(message))
        self.go_on()

    def _on_experiment(self, message: bytes) -> None:
        """Keep waiting while an experiment waits for its start; take over its last sample when it was stopped."""
        state = read_experiment_state(message)
        if state.state == "waiting":
            self.lockstep.hold()
        self._n_samples = min(self._run.n_samples, state.last_sample + 1)

    def _begin_pacing(self, command: FloatArray, now: float) -> None:
        self._newest_command = self.stamp
        self._pacing.begin(command, self._sample_time, self._node.value("real_time_patience"))
        self._node.poll(self._commands)
        if self.pause.on:
            self._pacing.step()
        else:
            self._pacing.go_on(now)

    def receive(self) -> bool:
        """Process one command received in real time; return whether there was one."""
        return self._node.take(self._commands)

    def on_cycle(self, command: FloatArray | None) -> None:
        """Execute a real-time cycle.

        Args:
            command: Newest command [Nm or N], shape (M,); None when it is too old.
        """
        if self.over:  # one of the received commands was rejected
            return
        try:
            if command is None:
                raise RunError(
                    controller_timeout_message(self.sample, self.stamp, self._node.value("real_time_patience"))
                )
            self._advance(command)
        except FlexrosError as error:
            self._on_end(error)

    # Pause.

    def begin_pause(self) -> None:
        """Pause at the present sample, whose command is kept."""
        if not self.pause.on:
            self.pause.begin(perf_counter())
            self._pacing.halt()

    def end_pause(self) -> None:
        """Resume the loop."""
        now = perf_counter()
        self._began += self.pause.end(now)
        if self._pacing.has_begun:
            self._pacing.go_on(now)
        self.go_on()

    def step(self) -> None:
        """Let one sample pass in a pause, at once or when its command arrives."""
        if self._pacing.has_begun:
            self._began += self.pause.passed(perf_counter())
            self._pacing.step()
        else:
            self.pause.step()
            self.go_on()
