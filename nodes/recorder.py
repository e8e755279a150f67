"""Recorder node: writes the messages on the topics of the contract to a log."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from std_msgs.msg import Header

from flexros.config.topics import load_topics
from flexros.errors import InputError, RunError
from flexros.logs.stamps import NANOSECONDS, START_NS, stamp_of
from flexros.logs.writer import LogWriter
from flexros_nodes.protocol.experiment_state import read_experiment_state
from flexros_nodes.protocol.loop.lockstep import RestartDetector
from flexros_nodes.protocol.own_joints import OwnJoints
from flexros_nodes.protocol.recorder.recording import ArrivalTime, EventRecording, TopicRecording
from flexros_nodes.protocol.sensor_messages import sensor_topics
from flexros_nodes.shell.executable import run_node
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.prepared_run import prepared_run
from flexros_nodes.shell.topic_interface import sampled_topics

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from flexros.config.topics import Topic

CONFIRM_PERIOD = 0.05
"""Longest time until a recording is confirmed [s] (wall clock), chosen."""

STALL_PERIODS = 16
"""In a stalled loop confirmations are repeated after 1, 2, 4, 8 and then every 16 periods, chosen."""

MARKERS = "arm_markers"
"""Topic that is recorded on request, so that a player shows the arm."""

LOOP_PRODUCERS = ("plant", "controller")
"""Nodes whose topics advance with the samples; the others may run ahead, or end."""


class RecorderNode(FlexrosNode):
    """Log of a run: raw messages in a rosbag2 folder; log time is the stamp, or the arrival time in real time.

    The node confirms on recorder_progress up to which stamp each topic is recorded, so that a run in lock-step never
    overruns it.
    """

    node_name = "recorder"
    _writer: LogWriter | None = None

    def configure(self) -> None:
        """Open the log and subscribe to the recorded topics."""
        run = prepared_run(self.value("scenario"))
        self._sample_time = run.sample_time
        self._joint_names = run.nominal.joint_names
        self._own_joints, self._restart = OwnJoints(self._joint_names), RestartDetector()
        real_time = bool(self.value("real_time"))
        self._provenance: Mapping[str, Any] = {**run.provenance(), "transport": "ros", "real_time": real_time}
        self._arrival = ArrivalTime(perf_counter) if real_time else None
        requested = [MARKERS] if self.value("markers") else []
        self._topics = {name: row for name, row in load_topics().items() if row.recorded or name in requested}
        self._all_confirmed = -1
        self._confirmed: dict[str, int] = {}
        self._seen: tuple[int, ...] = ()
        self._confirm_every = self.value("confirm_every")
        self._since_confirmed = self._stalls = 0
        self._samples: dict[str, TopicRecording] = {}
        self._in_loop: list[TopicRecording] = []
        self._events: dict[str, EventRecording] = {}
        self._writer = writer = self._open(list(self._topics.values()))
        self._closed = False
        sensors = sensor_topics(run.plant, run.sensor_timing)
        self._gaps = dict.fromkeys(sampled_topics(), 0) | {
            sensor.topic: round((sensor.period - 1) * self._sample_time * 1e9) for sensor in sensors
        }
        self._progress = self.announce("recorder_progress")
        for number, (name, row) in enumerate(self._topics.items(), 1):
            self._record(writer, name, row, number)
        self._stopped: Mapping[str, Any] | None = None
        self.listen("experiment_state", self._on_experiment)

    def _open(self, topics: list[Topic]) -> LogWriter:
        try:
            return LogWriter(Path(self.value("folder")), topics, self._provenance, namespace=self.get_namespace())
        except InputError as error:
            if isinstance(error.__cause__, OSError) and not isinstance(error.__cause__, FileExistsError):
                raise RunError(str(error)) from error  # the disk fails: the input is valid
            raise

    def _record(self, writer: LogWriter, name: str, row: Topic, number: int) -> None:
        if name not in self._gaps:
            present = self._present
            read_stamp = present if name == MARKERS else stamp_of  # the headers of markers are in a list
            self._events[name] = EventRecording(writer, number, self._arrival, present, read_stamp)
            self.listen(name, self._events[name].take, recorder=True)
            return
        recording = self._samples[name] = TopicRecording(
            writer, number, self._arrival, self._confirm_each, self._gaps[name]
        )
        if row.producer in LOOP_PRODUCERS:
            self._in_loop.append(recording)
        take = partial(self._take_state, recording) if name == "joint_states" else recording.take
        self.listen(name, take, recorder=True)

    def _present(self, *_: bytes) -> int:
        return self.stamp

    def _take_state(self, recording: TopicRecording, message: bytes) -> None:
        """Record a measurement of the robot; other nodes may publish their joints on the same topic."""
        if not self._own_joints.are_in(message):
            if self._own_joints.foreign == 1:
                self.get_logger().warning(
                    "a node publishes other joints on joint_states; its messages are not recorded: the robot of the "
                    f"scenario has {', '.join(self._joint_names)}"
                )
            return
        stamp = stamp_of(message)
        if stamp == START_NS < recording.last and self._restart.restarted(recording.last):
            raise RunError(
                f"the plant has begun again at its first sample, and the log holds samples to stamp "
                f"{recording.last / NANOSECONDS:.4f} s: a log holds one run; end the recorder before the plant begins "
                "again, or clean it up and configure it with another folder"
            )
        self._take_and_confirm(recording, message)

    def _take_and_confirm(self, recording: TopicRecording, message: bytes) -> None:
        if self._arrival is not None:
            self._arrival.begin()
        recording.take(message)
        self._since_confirmed += 1
        if self._arrival is not None:
            self.stamp = max(self.stamp, recording.last)
            return  # the loop waits for its first and last samples only, which the timer confirms
        if self._since_confirmed >= self._confirm_every and not self._confirm():
            self._confirm_each()  # the run was aborted: the plant brakes, and waits only for its own topics

    def _confirm(self) -> bool:
        """Confirm the stamp up to which all active topics of the loop are recorded; return whether it has advanced."""
        self._since_confirmed = 0
        until = min((recording.until for recording in self._in_loop if recording.count), default=-1)
        if until <= self._all_confirmed:
            return False
        self.stamp = self._all_confirmed = until
        self.publish_progress("", until)
        return True

    def _confirm_each(self) -> bool:
        """Confirm the recorded stamp of each topic that has advanced; return whether any has."""
        advanced = self._confirm()
        for name, recording in self._samples.items():
            if recording.until > self._confirmed.get(name, -1):
                advanced = True
                self._confirmed[name] = recording.until
                self.publish_progress(name, recording.until)
        return advanced

    def _confirm_periodically(self) -> None:
        """Confirm new recordings; in a stalled loop repeat the confirmations.

        The plant may have discovered this recorder only now, and would wait forever for the earlier ones.
        """
        if self._arrival is not None and self._is_advancing():
            return  # in real time the loop does not wait: the beginning and the end are confirmed
        self._stalls = 0 if self._confirm_each() else self._stalls + 1
        if self._stalls and (self._stalls & (self._stalls - 1) == 0 or self._stalls % STALL_PERIODS == 0):
            for name, stamp in {"": self._all_confirmed, **self._confirmed}.items():
                if stamp >= 0:
                    self.publish_progress(name, stamp)

    def _is_advancing(self) -> bool:
        """Whether every topic of the loop that has been confirmed goes on, which needs no further confirmation."""
        before, self._seen = self._seen, tuple(recording.until for recording in self._in_loop)
        confirmed = all(name in self._confirmed for name, recording in self._samples.items() if recording.count)
        return confirmed and all(now > then for now, then in zip(self._seen, before, strict=False) if now >= 0)

    def _on_experiment(self, message: bytes) -> None:
        """Store the state of an experiment that the user has stopped."""
        state = read_experiment_state(message)
        if state.stopped_at_sample >= 0:
            self._stopped = state.as_dict()

    def publish_progress(self, name: str, stamp: int) -> None:
        """Confirm that a topic is recorded up to a stamp [ns]; an empty name means all topics of the loop."""
        message = Header(frame_id=name)
        message.stamp.sec, message.stamp.nanosec = divmod(stamp, NANOSECONDS)
        self._progress.publish(message)

    def start(self) -> None:
        """Confirm periodically, also in a stalled loop."""
        self.every(CONFIRM_PERIOD, self._confirm_periodically)

    def refusal(self) -> str:
        """Refuse to continue a closed log."""
        if not self._closed:
            return ""
        folder = self.value("folder")
        return f"the log {folder} is closed; clean up the node and configure it with another folder"

    def stop(self) -> None:
        """Close the log."""
        if self._writer is not None and not self._closed:
            self._closed = True
            stopped = {} if self._stopped is None else {"stopped": self._stopped}
            self._writer.close({**self._provenance, **stopped, "recorded": self.figures()})

    def release(self) -> None:
        """Close the log of a run that never started."""
        self.stop()
        self._writer = None

    def figures(self) -> dict[str, float]:
        """Return the numbers of written, repeated and missing messages by topic."""
        figures: dict[str, float] = {}
        for name, recording in self._samples.items():
            figures[f"{name}.messages"] = recording.count
            figures[f"{name}.repeated"] = recording.repeated
            figures[f"{name}.missing"] = recording.missing(self._sample_time)
            if recording.doubted:
                figures[f"{name}.doubted"] = recording.doubted
        figures |= {f"{name}.messages": events.count for name, events in self._events.items()}
        return figures


def main() -> int:
    """Run the node in this process."""
    return run_node(RecorderNode)


if __name__ == "__main__":
    raise SystemExit(main())
