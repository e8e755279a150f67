"""Gap monitor node: the nominal robot beside a running one; tells on /diagnostics how far both are apart, and where."""

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
    motor_sentence,
    motor_values,
    robot_sentence,
    robot_values,
    stands_still,
    torque_units,
)
from flexros_nodes.shell.executable import run_node
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic

if TYPE_CHECKING:
    from collections.abc import Mapping

LOOK_PERIOD = 0.1
"""Period at which messages are taken up [s], chosen: a window."""

SILENCE = 2.0
"""Time without messages of a topic from which the node says so [s], chosen."""

LEVELS = {Level.OK: DiagnosticStatus.OK, Level.WARNING: DiagnosticStatus.WARN, Level.ALARM: DiagnosticStatus.ERROR}


class GapMonitorNode(FlexrosNode):
    """Observer of a robot: nobody waits for it, it asks nobody for repeats, and it publishes on /diagnostics alone."""

    node_name = "gap_monitor"
    monitor: GapMonitor | None = None

    def configure(self) -> None:
        """Load the model, make the twin, and listen to states and commands."""
        if not self.value("model"):
            raise InputError("parameter model of node gap_monitor is empty; give a robot, by name or file, or a patch")
        known = load_patched(self.value("model"))
        calibration = None
        if self.value("thresholds"):
            path = Path(self.value("thresholds"))
            calibration = read_calibration(path, known.fingerprint, known.base.joint_names)
        self.monitor = GapMonitor(known.model, false_alarms=self.value("false_alarms"), calibration=calibration)
        self._units = torque_units(known.base)
        self._budget = LoadBudget(self.value("max_load"))
        self._used = 0.0
        self._passed_over = 0
        self._waiting: dict[str, list[bytes]] = {}
        self._readers = {}
        for name, field in (("joint_states", "position"), ("joint_commands", "effort")):
            self._waiting[name] = []
            self._readers[name] = JointMessages(known.base, name, field)
            self._hear(name)

    def _hear(self, name: str) -> None:
        """Subscribe as the recorder does, but without asking for repeats."""
        row = topic(name)
        profile = qos_profile(row.qos.model_copy(update={"reliability": "best_effort"}))
        subscription = self.create_subscription(
            message_class(row.type), row.name, partial(self._take, name), profile, raw=True
        )
        self._made.append(partial(self.destroy_subscription, subscription))

    def _take(self, name: str, message: bytes) -> None:
        if self.active:
            self._waiting[name].append(message)

    def start(self) -> None:
        """Begin to watch."""
        self._begun = perf_counter()
        self._heard = dict.fromkeys(self._waiting, self._begun)
        for messages in self._waiting.values():
            messages.clear()
        self.every(LOOK_PERIOD, self._watch)
        self.every(self.value("period"), self._tell)

    def _watch(self) -> None:
        """Watch what has come since the last time, where there is processor time for it."""
        monitor, now = self._watching(), perf_counter()
        allowed = self._budget.allows(now)
        begun = thread_time()
        for name, add in (("joint_states", monitor.add_states), ("joint_commands", monitor.add_commands)):
            messages = self._waiting[name]
            if messages:
                self._heard[name] = now
            if allowed:
                add(*self._readers[name].take(messages))
            else:
                self._passed_over += len(messages)
            messages.clear()
        if allowed:
            monitor.advance()
        used = thread_time() - begun
        self._budget.use(used)
        self._used += used

    def _watching(self) -> GapMonitor:
        if self.monitor is None:
            raise InputError("the gap monitor is not configured; configure it first")
        return self.monitor

    def _tell(self) -> None:
        """Publish one status for the robot and one for each motor."""
        begun = thread_time()
        reading = self._watching().reading()
        level, text = LEVELS[reading.level], robot_sentence(reading)
        not_heard = self._not_heard()
        if not_heard:
            text = f"{text}; {not_heard}"
        if not_heard or stands_still(reading):
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
        self._budget.use(used)
        self._used += used

    def _not_heard(self) -> str:
        """Say which topics are silent or cannot be used."""
        now = perf_counter()
        silent = [name for name, last in self._heard.items() if now - last > SILENCE]
        problems = [reader.problem for reader in self._readers.values() if reader.problem]
        told = [f"nothing is heard on {' and '.join(silent)}"] if silent else []
        return "; ".join([*told, *problems])

    def _status(self, name: str, level: bytes, message: str, values: Mapping[str, float | str]) -> DiagnosticStatus:
        pairs = [
            KeyValue(key=key, value=value if isinstance(value, str) else f"{value:.9g}")
            for key, value in values.items()
        ]
        return DiagnosticStatus(
            level=level, name=name, message=message, hardware_id=self._watching().robot.name, values=pairs
        )

    def figures(self) -> dict[str, float]:
        """Give what was watched, what was not and why, and what it cost."""
        monitor = self._watching()
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
            "passed_over": self._passed_over,
            "restarts": counts.restarts,
            "processor_time_s": self._used,
        }


def main() -> int:
    """Run the node as an executable."""
    return run_node(GapMonitorNode)


if __name__ == "__main__":
    raise SystemExit(main())
