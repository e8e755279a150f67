"""Gap monitor node: compares a running robot with its model and publishes the mismatch on /diagnostics."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from time import perf_counter, thread_time
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError
from flexros.logs.stamps import NANOSECONDS
from flexros.monitor.alarms import Level
from flexros.monitor.calibration import read_calibration
from flexros.monitor.gap_monitor import GapMonitor
from flexros.monitor.joint_messages import JointMessages
from flexros.monitor.load_budget import LoadBudget
from flexros.monitor.statement import (
    is_suspended,
    motor_sentence,
    motor_values,
    robot_sentence,
    robot_values,
    torque_units,
)
from flexros_nodes.shell.executable import run_node
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic

if TYPE_CHECKING:
    from collections.abc import Mapping

UPDATE_PERIOD = 0.1
"""Period at which messages are processed [s], chosen: one window."""

SILENCE = 2.0
"""Time without messages of a topic after which the node reports it [s], chosen."""

LEVELS = {Level.OK: DiagnosticStatus.OK, Level.WARNING: DiagnosticStatus.WARN, Level.ALARM: DiagnosticStatus.ERROR}


class GapMonitorNode(FlexrosNode):
    """Passive monitor: no node waits for it, it requests no repeats and publishes only on /diagnostics."""

    node_name = "gap_monitor"
    monitor: GapMonitor | None = None

    def configure(self) -> None:
        """Load the model, create the monitor, and subscribe to states and commands."""
        if not self.value("model"):
            raise InputError("parameter model of node gap_monitor is empty; give a robot, by name or file, or a patch")
        model = load_patched(self.value("model"))
        calibration = None
        if self.value("thresholds"):
            path = Path(self.value("thresholds"))
            calibration = read_calibration(path, model.fingerprint, model.base.joint_names)
        self.monitor = GapMonitor(model.model, false_alarms=self.value("false_alarms"), calibration=calibration)
        self._units = torque_units(model.base)
        self.budget = LoadBudget(self.value("max_load"))
        self._used = 0.0
        self._skipped = 0
        self._waiting: dict[str, list[bytes]] = {}
        self._readers: dict[str, JointMessages] = {}
        for name, field in (("joint_states", "position"), ("joint_commands", "effort")):
            self._waiting[name] = []
            self._readers[name] = JointMessages(model.base, name, field, self._readers.get("joint_states"))
            self._subscribe(name)

    def _subscribe(self, name: str) -> None:
        """Subscribe with the depth of the recorder, but best effort."""
        row = topic(name)
        profile = qos_profile(row.qos.model_copy(update={"reliability": "best_effort"}))
        subscription = self.create_subscription(
            message_class(row.type), row.name, partial(self._take, name), profile, raw=True
        )
        self.on_close(partial(self.destroy_subscription, subscription))

    def _take(self, name: str, message: bytes) -> None:
        if self.active:
            self._waiting[name].append(message)

    def start(self) -> None:
        """Start monitoring."""
        self._begun = perf_counter()
        self._heard = dict.fromkeys(self._waiting, self._begun)
        for messages in self._waiting.values():
            messages.clear()
        self.every(UPDATE_PERIOD, self._update)
        self.every(self.value("period"), self._publish_diagnostics)

    def _update(self) -> None:
        """Process the messages received since the last call, as far as the processor budget allows."""
        monitor, now = self._configured_monitor(), perf_counter()
        allowed = self.budget.allows(now)
        begun = thread_time()
        for name, add in (("joint_states", monitor.add_states), ("joint_commands", monitor.add_commands)):
            messages = self._waiting[name]
            if messages:
                self._heard[name] = now
            if allowed:
                add(*self._readers[name].take(messages))
            else:
                self._skipped += len(messages)
            messages.clear()
        if allowed:
            monitor.advance()
        used = thread_time() - begun
        self.budget.use(used)
        self._used += used

    def _configured_monitor(self) -> GapMonitor:
        if self.monitor is None:
            raise InputError("the gap monitor is not configured; configure it first")
        return self.monitor

    def _publish_diagnostics(self) -> None:
        """Publish one status for the robot and one for each motor."""
        begun = thread_time()
        reading = self._configured_monitor().reading()
        level, text = LEVELS[reading.level], robot_sentence(reading)
        input_problems = self._input_problems()
        if input_problems:
            text = f"{text}; {input_problems}"
        if input_problems or is_suspended(reading):
            level = max(level, DiagnosticStatus.WARN)
        name = self.get_fully_qualified_name()
        statuses = [self._status(name, level, text, {**robot_values(reading), **self.figures()})]
        for motor, unit in zip(reading.motors, self._units):
            own = self._status(
                f"{name}: {motor.name}", LEVELS[motor.alarm.level], motor_sentence(motor, unit), motor_values(motor)
            )
            statuses.append(own)
        self.stamp = max(reading.stamp, self.stamp)
        array = DiagnosticArray(status=statuses)
        array.header.stamp.sec, array.header.stamp.nanosec = divmod(self.stamp, NANOSECONDS)
        self._diagnostics.publish(array)
        used = thread_time() - begun
        self.budget.use(used)
        self._used += used

    def _input_problems(self) -> str:
        """Return which topics are silent or unusable."""
        now = perf_counter()
        silent = [name for name, last in self._heard.items() if now - last > SILENCE]
        problems = [reader.problem for reader in self._readers.values() if reader.problem]
        silence = [f"no messages on {' and '.join(silent)}"] if silent else []
        return "; ".join([*silence, *problems])

    def _status(self, name: str, level: bytes, message: str, values: Mapping[str, float | str]) -> DiagnosticStatus:
        pairs = [
            KeyValue(key=key, value=value if isinstance(value, str) else f"{value:.9g}")
            for key, value in values.items()
        ]
        return DiagnosticStatus(
            level=level, name=name, message=message, hardware_id=self._configured_monitor().robot.name, values=pairs
        )

    def figures(self) -> dict[str, float]:
        """Return counts of processed and skipped data, and the processor time used."""
        monitor = self._configured_monitor()
        counts = monitor.counts
        return {
            "windows": monitor.windows,
            "settling_windows": monitor.settled,
            "lost_windows": counts.lost_windows,
            "alarms": monitor.alarms,
            "warnings": monitor.warnings,
            "runaways": monitor.runaways,
            "states": counts.states,
            "commands": counts.commands,
            "missing_states": counts.missing,
            "late_messages": counts.late,
            "unusable_messages": counts.unusable + sum(reader.unusable for reader in self._readers.values()),
            "passed_over": self._skipped,
            "restarts": counts.restarts,
            "processor_time_s": self._used,
        }


def main() -> int:
    """Run the node in this process."""
    return run_node(GapMonitorNode)


if __name__ == "__main__":
    raise SystemExit(main())
