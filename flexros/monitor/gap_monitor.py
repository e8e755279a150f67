"""The gap monitor: takes states and commands of a robot as they come, tells how far its model is from it, and where."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.monitor.alarms import Alarms, Level, MotorAlarm
from flexros.monitor.disturbance_location import Suspicion, close, places_of, suspicions
from flexros.monitor.sample_stream import SampleStream
from flexros.monitor.thresholds import FALSE_ALARMS, thresholds
from flexros.monitor.watch import Watch

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import FloatArray, IntArray
    from flexros.effects import RobotWithEffects
    from flexros.monitor.calibration import Calibration
    from flexros.monitor.design import Design
    from flexros.monitor.design_book import DesignBook
    from flexros.monitor.topic_queue import Counts
    from flexros.monitor.watch import Missed
    from flexros.robot import Robot

RECENT = 10
"""Windows over which the running gap is taken: a second (chosen)."""
LOOKED_AT = 20
"""Windows whose errors are kept for the place of the gap: two seconds (chosen)."""
FEWEST = 3
"""Windows from which a place is told (chosen)."""


@dataclass(frozen=True, eq=False)
class MotorReading:
    """What the monitor tells of a motor, over the last second.

    Attributes:
        name: Name of the motor.
        alarm: Its state.
        gap: Larger of the two below [1].
        sudden: Sudden part of the prediction errors, rms over that of noise [1].
        slow: Missing torque, rms over that of noise [1].
        torque: Missing torque, mean and rms [Nm or N].
        torque_floor: Rms of the missing torque that noise alone shows [Nm or N].
    """

    name: str
    alarm: MotorAlarm
    gap: float
    sudden: float
    slow: float
    torque: tuple[float, float]
    torque_floor: float


@dataclass(frozen=True, eq=False)
class MonitorReading:
    """What the monitor tells of a robot.

    Attributes:
        stamp: Stamp up to which it has watched [ns]; -1 before the first window.
        motors: Its motors.
        settling: Whether the twin is still finding the robot, so that nothing is watched.
        suspected: Places of the gap, the likeliest first; empty where there is none.
        seen: Share of the time that was watched [1].
        unpaired: Time of the newest states for which there are no commands [s].
    """

    stamp: int
    motors: tuple[MotorReading, ...]
    settling: bool
    suspected: tuple[Suspicion, ...]
    seen: float
    unpaired: float

    @property
    def level(self) -> Level:
        """Highest level of all motors."""
        return max((motor.alarm.level for motor in self.motors), default=Level.OK)


class GapMonitor:
    """Watches a robot beside its nominal twin; pure, a function of the messages alone.

    Args:
        model: The nominal model, robot and laws of effects that are known.
        false_alarms: Rate of false alarms of the whole monitor [1/h].
        calibration: What the robot misses as it is accepted; None for a robot that is as its model.

    Attributes:
        windows: Windows that were watched.
        settled: Windows in which the twin was finding the robot.
    """

    def __init__(
        self, model: RobotWithEffects, *, false_alarms: float = FALSE_ALARMS, calibration: Calibration | None = None
    ) -> None:
        self._model, self._false_alarms, self._calibration = model, false_alarms, calibration
        self.stream = SampleStream(model.robot.sample_time, model.robot.n_motors)
        self._watch: Watch | None = None
        self._alarms: Alarms | None = None
        self._missed: deque[Missed] = deque(maxlen=LOOKED_AT)
        self._stamp = -1
        self.windows = self.settled = 0

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self._model.robot

    @property
    def counts(self) -> Counts:
        """What happened to the messages."""
        return self.stream.counts

    @property
    def book(self) -> DesignBook:
        """Designs for the poses of the robot, once the sample time is known.

        Raises:
            InputError: It is not known as yet.
        """
        if self._watch is None:
            raise InputError("the monitor has no design before it knows the sample time; give it messages first")
        return self._watch.book

    @property
    def alarms(self) -> int:
        """Times that there was an alarm."""
        return 0 if self._alarms is None else self._alarms.raised

    @property
    def warnings(self) -> int:
        """Times that there was a warning or an alarm."""
        return 0 if self._alarms is None else self._alarms.warned

    @property
    def runaways(self) -> int:
        """Times that the twin lost the robot."""
        return 0 if self._watch is None else self._watch.runaways

    def add_states(self, stamp: IntArray, position: FloatArray) -> None:
        """Take measurements: stamps [ns], shape (n,), and motor positions [rad or m], shape (n, M)."""
        self.stream.add_states(stamp, position)

    def add_commands(self, stamp: IntArray, torque: FloatArray) -> None:
        """Take commands: stamps [ns], shape (n,), and torques [Nm or N], shape (n, M)."""
        self.stream.add_commands(stamp, torque)

    def advance(self) -> list[Missed]:
        """Watch what is complete.

        Returns:
            What the twin missed in each window that could be watched.

        Raises:
            InputError: The rate of the states is none that can be watched.
        """
        return [missed for missed in self.each() if missed is not None]

    def each(self) -> Iterator[Missed | None]:
        """Watch what is complete, and give what the twin missed window by window; None where it found the robot.

        Raises:
            InputError: The rate of the states is none that can be watched.
        """
        for window in self.stream.windows():
            watch, alarms = self._made()
            runaways = watch.runaways
            if window.stamp < self._stamp:
                alarms.forget()
            missed = watch.take(window)
            self._stamp = window.stamp
            if watch.runaways > runaways:
                alarms.lost(window.stamp)
            if missed is None:
                self.settled += 1
                self._missed.clear()
                alarms.begin_anew()
            else:
                self.windows += 1
                self._missed.append(missed)
                values = np.concatenate([missed.sudden, missed.slow])
                if self._calibration is not None:
                    values = values / self._calibration.expected(missed.motion)
                alarms.take(window.stamp, values)
            yield missed

    @property
    def level(self) -> Level:
        """Highest level of all motors at the last window."""
        return Level.OK if self._alarms is None else Level(int(self._alarms.levels(self._stamp).max()))

    def reading(self) -> MonitorReading:
        """Tell what was found."""
        if self._watch is None or self._alarms is None:
            return MonitorReading(-1, (), True, (), 0.0, self.stream.unpaired)
        states = self._alarms.states(self._stamp)
        passed = self.windows + self.settled + self.counts.lost_windows
        suspected = self._suspected() if any(state.level for state in states) else ()
        motors = self._motors(states)
        seen = self.windows / max(passed, 1)
        return MonitorReading(self._stamp, motors, self._watch.settling, suspected, seen, self.stream.unpaired)

    def _made(self) -> tuple[Watch, Alarms]:
        """Make twin and thresholds once the sample time is known, and anew where it has changed."""
        stream = self.stream
        if self._watch is None or self._alarms is None or self._watch.sample_time != stream.sample_time:
            self._watch = watch = Watch(self._model, stream.sample_time, stream.samples)
            rate, calibration = self._false_alarms, self._calibration
            limits = thresholds(watch.book, stream.samples, false_alarms=rate, calibration=calibration)
            self._alarms = Alarms(limits)
        return self._watch, self._alarms

    def _motors(self, states: tuple[MotorAlarm, ...]) -> tuple[MotorReading, ...]:
        recent = list(self._missed)[-RECENT:]
        assert self._watch is not None
        names, M = self._model.robot.joint_names, len(states)
        sudden, slow = (
            np.sqrt(np.mean([getattr(one, name) for one in recent], axis=0)) if recent else np.full(M, np.nan)
            for name in ("sudden", "slow")
        )
        torque = np.full((2, M), np.nan)
        if recent:
            torque[0] = np.mean([one.torque[0] for one in recent], axis=0)
            torque[1] = np.sqrt(np.mean([one.torque[1] ** 2 for one in recent], axis=0))
        floors = self._watch.here.design.torque_spread
        return tuple(
            MotorReading(
                name=names[motor],
                alarm=states[motor],
                gap=float(max(sudden[motor], slow[motor])),
                sudden=float(sudden[motor]),
                slow=float(slow[motor]),
                torque=(float(torque[0, motor]), float(torque[1, motor])),
                torque_floor=float(floors[motor]),
            )
            for motor in range(M)
        )

    def _suspected(self) -> tuple[Suspicion, ...]:
        """Say where the gap of the last seconds lies; nothing where too little of it is known."""
        assert self._watch is not None
        stretch = _longest_stretch(list(self._missed))
        if len(stretch) < FEWEST:
            return ()
        found: Design = stretch[-1].design
        errors = np.concatenate([one.sudden_part for one in stretch])
        robot, book = self._model.robot, self._watch.book
        ranked = suspicions(errors, found, places_of(robot, found), book.noise, self.stream.sample_time)
        return close(ranked)


def _longest_stretch(missed: list[Missed]) -> list[Missed]:
    """Give the longest run of windows with one design, the last one of several."""
    best: list[Missed] = []
    run: list[Missed] = []
    for one in missed:
        run = [*run, one] if run and run[-1].design is one.design else [one]
        best = run if len(run) >= len(best) else best
    return best
