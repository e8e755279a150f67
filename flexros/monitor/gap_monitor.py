"""The gap monitor: detects and locates deviations of a running robot from its model, from states and commands."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.monitor.alarms import Alarms, Level, MotorAlarm
from flexros.monitor.disturbance_location import LocationGain, close, locations_of, ranked_locations
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
    from flexros.monitor.watch import WindowResult
    from flexros.robot import Robot

RECENT = 10
"""Windows over which the current gap is averaged: a second (chosen)."""
LOOKED_AT = 20
"""Windows whose innovations are kept to locate the gap: two seconds (chosen)."""
FEWEST = 3
"""Fewest windows that locate a gap (chosen)."""


@dataclass(frozen=True, eq=False)
class MotorReading:
    """Figures of a motor over the last second.

    Attributes:
        name: Name of the motor.
        alarm: Its state.
        gap: Larger of the two below [1].
        innovation: Rms of the innovations over that of noise [1].
        disturbance: Rms of the disturbance torque over that of noise [1].
        torque: Disturbance torque, mean and rms [Nm or N].
        torque_floor: Rms of the disturbance torque estimated from noise alone [Nm or N].
    """

    name: str
    alarm: MotorAlarm
    gap: float
    innovation: float
    disturbance: float
    torque: tuple[float, float]
    torque_floor: float


@dataclass(frozen=True, eq=False)
class MonitorReading:
    """Figures of a robot.

    Attributes:
        stamp: Stamp of the last window [ns]; -1 before the first one.
        motors: Its motors.
        settling: Whether the observer is still converging, so that nothing is monitored.
        locations: Likely locations of the gap, the most likely first; empty where there is none.
        seen: Share of the time that was monitored [1].
        unpaired: Time of the newest states for which there are no commands [s].
    """

    stamp: int
    motors: tuple[MotorReading, ...]
    settling: bool
    locations: tuple[LocationGain, ...]
    seen: float
    unpaired: float

    @property
    def level(self) -> Level:
        """Highest level of all motors."""
        return max((motor.alarm.level for motor in self.motors), default=Level.OK)


class GapMonitor:
    """Monitors a robot with an observer model; a function of the messages alone.

    Args:
        model: The nominal model: robot and laws of known effects.
        false_alarms: Rate of false alarms of the whole monitor [1/h].
        calibration: Accepted deviations of the robot; None for an exact model.

    Attributes:
        windows: Windows that were monitored.
        settled: Windows in which the observer was converging.
    """

    def __init__(
        self, model: RobotWithEffects, *, false_alarms: float = FALSE_ALARMS, calibration: Calibration | None = None
    ) -> None:
        self._model, self._false_alarms, self._calibration = model, false_alarms, calibration
        self.stream = SampleStream(model.robot.sample_time, model.robot.n_motors)
        self._watch: Watch | None = None
        self._alarms: Alarms | None = None
        self._results: deque[WindowResult] = deque(maxlen=LOOKED_AT)
        self._stamp = -1
        self.windows = self.settled = 0

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self._model.robot

    @property
    def counts(self) -> Counts:
        """Counts of messages and windows."""
        return self.stream.counts

    @property
    def book(self) -> DesignBook:
        """Designs for the poses of the robot, once the sample time is known.

        Raises:
            InputError: It is not known yet.
        """
        if self._watch is None:
            raise InputError("the monitor has no design before the sample time is known; add messages first")
        return self._watch.book

    @property
    def alarms(self) -> int:
        """Number of alarms."""
        return 0 if self._alarms is None else self._alarms.raised

    @property
    def warnings(self) -> int:
        """Number of warnings and alarms."""
        return 0 if self._alarms is None else self._alarms.warned

    @property
    def runaways(self) -> int:
        """Number of times that the observer diverged."""
        return 0 if self._watch is None else self._watch.runaways

    def add_states(self, stamp: IntArray, position: FloatArray) -> None:
        """Add measurements: stamps [ns], shape (n,), and motor positions [rad or m], shape (n, M)."""
        self.stream.add_states(stamp, position)

    def add_commands(self, stamp: IntArray, torque: FloatArray) -> None:
        """Add commands: stamps [ns], shape (n,), and torques [Nm or N], shape (n, M)."""
        self.stream.add_commands(stamp, torque)

    def advance(self) -> list[WindowResult]:
        """Evaluate the complete windows.

        Returns:
            Results of the windows that could be evaluated.

        Raises:
            InputError: The rate of the states is outside the limits.
        """
        return [result for result in self.each() if result is not None]

    def each(self) -> Iterator[WindowResult | None]:
        """Evaluate the complete windows one by one; yield None while the observer converges.

        Raises:
            InputError: The rate of the states is outside the limits.
        """
        for window in self.stream.windows():
            watch, alarms = self._made()
            runaways = watch.runaways
            if window.stamp < self._stamp:
                alarms.forget()
            result = watch.take(window)
            self._stamp = window.stamp
            if watch.runaways > runaways:
                alarms.diverged(window.stamp)
            if result is None:
                self.settled += 1
                self._results.clear()
                alarms.restart()
            else:
                self.windows += 1
                self._results.append(result)
                values = np.concatenate([result.innovation, result.disturbance])
                if self._calibration is not None:
                    values = values / self._calibration.expected(result.motion)
                alarms.take(window.stamp, values)
            yield result

    @property
    def level(self) -> Level:
        """Highest level of all motors at the last window."""
        return Level.OK if self._alarms is None else Level(int(self._alarms.levels(self._stamp).max()))

    def reading(self) -> MonitorReading:
        """Return the current figures."""
        if self._watch is None or self._alarms is None:
            return MonitorReading(-1, (), True, (), 0.0, self.stream.unpaired)
        states = self._alarms.states(self._stamp)
        passed = self.windows + self.settled + self.counts.lost_windows
        locations = self._locations() if any(state.level for state in states) else ()
        motors = self._motors(states)
        seen = self.windows / max(passed, 1)
        return MonitorReading(self._stamp, motors, self._watch.settling, locations, seen, self.stream.unpaired)

    def _made(self) -> tuple[Watch, Alarms]:
        """Create observer and thresholds once the sample time is known, and again where it has changed."""
        stream = self.stream
        if self._watch is None or self._alarms is None or self._watch.sample_time != stream.sample_time:
            self._watch = watch = Watch(self._model, stream.sample_time, stream.samples)
            rate, calibration = self._false_alarms, self._calibration
            limits = thresholds(watch.book, stream.samples, false_alarms=rate, calibration=calibration)
            self._alarms = Alarms(limits)
        return self._watch, self._alarms

    def _motors(self, states: tuple[MotorAlarm, ...]) -> tuple[MotorReading, ...]:
        recent = list(self._results)[-RECENT:]
        assert self._watch is not None
        names, M = self._model.robot.joint_names, len(states)
        innovation, disturbance = (
            np.sqrt(np.mean([getattr(result, name) for result in recent], axis=0)) if recent else np.full(M, np.nan)
            for name in ("innovation", "disturbance")
        )
        torque = np.full((2, M), np.nan)
        if recent:
            torque[0] = np.mean([result.torque[0] for result in recent], axis=0)
            torque[1] = np.sqrt(np.mean([result.torque[1] ** 2 for result in recent], axis=0))
        floors = self._watch.here.design.torque_spread
        return tuple(
            MotorReading(
                name=names[motor],
                alarm=states[motor],
                gap=float(max(innovation[motor], disturbance[motor])),
                innovation=float(innovation[motor]),
                disturbance=float(disturbance[motor]),
                torque=(float(torque[0, motor]), float(torque[1, motor])),
                torque_floor=float(floors[motor]),
            )
            for motor in range(M)
        )

    def _locations(self) -> tuple[LocationGain, ...]:
        """Locate the gap of the last seconds; empty where too few windows are available."""
        assert self._watch is not None
        stretch = _longest_stretch(list(self._results))
        if len(stretch) < FEWEST:
            return ()
        design: Design = stretch[-1].design
        innovations = np.concatenate([result.innovations for result in stretch])
        robot, book = self._model.robot, self._watch.book
        ranked = ranked_locations(innovations, design, locations_of(robot, design), book.noise, self.stream.sample_time)
        return close(ranked)


def _longest_stretch(results: list[WindowResult]) -> list[WindowResult]:
    """Return the longest run of windows with one design, the last one of several."""
    best: list[WindowResult] = []
    run: list[WindowResult] = []
    for result in results:
        run = [*run, result] if run and run[-1].design is result.design else [result]
        best = run if len(run) >= len(best) else best
    return best
