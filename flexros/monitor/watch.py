"""Watching a robot window by window: what the twin misses, once it has found the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.monitor.design_book import DesignBook
from flexros.monitor.observer_model import ObserverModel

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.monitor.design import Design
    from flexros.monitor.design_book import PoseDesign
    from flexros.monitor.sample_stream import Window

CORRECTIONS = 5
"""Times that the twin is moved to where its filter sees the robot, after a start in motion (chosen)."""
BETWEEN = 2.0
"""Time between them in time constants of the filter: an error falls to a seventh each time (chosen)."""
AT_REST = 3.0
"""Time that a start at rest takes, in time constants of the filter (chosen)."""
PARTS = 4
"""Parts of a window from whose mean positions speeds and accelerations are taken (chosen)."""
STAYS = 1.0
"""Shortest time with one design [s]: making one takes some 40 ms for six axes (chosen)."""


@dataclass(frozen=True, eq=False)
class Missed:
    """What the twin missed in a window.

    Attributes:
        stamp: Stamp of the first sample [ns].
        sudden: Mean square of the sudden part of its errors, over that of noise [1], shape (M,).
        slow: Mean square of the missing torques, over that of noise [1], shape (M,).
        torque: Missing torque, mean and rms [Nm or N], shape (2, M).
        motion: Mean squares of torques, speeds and accelerations of the motors [SI], shape (3 M,).
        sudden_part: Sudden part of the prediction errors [rad or m], shape (samples, M).
        design: Design that made it.
    """

    stamp: int
    sudden: FloatArray
    slow: FloatArray
    torque: FloatArray
    motion: FloatArray
    sudden_part: FloatArray
    design: Design


class Watch:
    """Runs the twin and its filter.

    Args:
        model: The nominal model.
        sample_time: Time between two samples [s].
        samples: Samples of a window.

    Attributes:
        sample_time: Time between two samples [s].
        book: Designs for poses.
        settling: Whether the twin is still finding the robot.
        runaways: Times that it lost the robot.
    """

    def __init__(self, model: RobotWithEffects, sample_time: float, samples: int) -> None:
        self.book = DesignBook(model, sample_time, samples)
        self._twin = ObserverModel(model, sample_time)
        self.sample_time, self._samples = sample_time, samples
        self._stay = max(round(STAYS / (sample_time * samples)), 1)
        self._cell = self.book.home
        self._here = self.book.at(self._cell)
        self._running = False
        self.settling = True
        self.runaways = 0

    @property
    def here(self) -> PoseDesign:
        """The design in use."""
        return self._here

    def take(self, window: Window) -> Missed | None:
        """Take the next window.

        Args:
            window: The window.

        Returns:
            What the twin missed; None while it is finding the robot.
        """
        try:
            if window.anew or not self._running:
                self._begin(window)
            self._follow_pose(window.position[0])
            errors = self._twin.run(window, self.book.gain)
        except (InputError, np.linalg.LinAlgError):  # no rest, or no filter, where the robot is said to be
            errors = None
        if errors is None:
            self.runaways += 1
            self._running, self.settling = False, True
            return None
        if not window.measured.all():
            rows, there = np.arange(len(errors)), np.flatnonzero(window.measured)
            errors = np.stack([np.interp(rows, there, column) for column in errors[there].T], axis=1)
        sudden, torque = self._filtered(errors)
        if self.settling:
            self._settle()
            return None
        return self._missed(window, sudden, torque)

    def _begin(self, window: Window) -> None:
        self._twin.begin(window)
        self._cell = self.book.cell(window.position[0])
        self._here = self.book.at(self._cell)
        self._since_design = 0
        self._state = np.zeros(len(self._here.lifted.A))
        self._corrections = CORRECTIONS if self._twin.starts_in_motion else 0
        self._wait = self._windows(BETWEEN if self._corrections else AT_REST)
        self._running = self.settling = True

    def _windows(self, time_constants: float) -> int:
        return int(np.ceil(time_constants * self._here.design.settling / self._samples))

    def _follow_pose(self, position: FloatArray) -> None:
        """Take the design of another cell now and then."""
        self._since_design += 1
        if self._since_design >= self._stay or self.settling:
            cell = self.book.cell(position)
            if cell != self._cell:
                self._cell, self._here, self._since_design = cell, self.book.at(cell), 0

    def _filtered(self, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lead errors through the filter: sudden parts, shape (samples, M), and missing torques, (blocks, M)."""
        lifted, M = self._here.lifted, errors.shape[1]
        outputs = np.empty((self._samples // self.book.block, self.book.block, 2 * M))
        for number, block in enumerate(errors.reshape(-1, self.book.block * M)):
            outputs[number] = (lifted.C @ self._state + lifted.D @ block).reshape(self.book.block, 2 * M)
            self._state = lifted.A @ self._state + lifted.B @ block
        return outputs[:, :, :M].reshape(-1, M), outputs[:, -1, M:]

    def _settle(self) -> None:
        """Move the twin to where its filter sees the robot, when the filter has had its time."""
        self._wait -= 1
        if self._wait > 0:
            return
        if self._corrections == 0:
            self.settling = False
            return
        robot = len(self.book.gain)
        self._twin.correct(self._state[:robot])
        self._state[:robot] = 0.0
        self._corrections -= 1
        self._wait = self._windows(BETWEEN)

    def _motion(self, window: Window) -> FloatArray:
        """Tell how much the robot does: mean squares of torques, speeds and accelerations, shape (3 M,)."""
        parts = np.array_split(window.position, PARTS)
        step = self.sample_time * self._samples / PARTS
        position = np.array([part.mean(axis=0) for part in parts])
        rates = [np.diff(position, order, axis=0) / step**order for order in (1, 2)]
        return np.concatenate([np.mean(one**2, axis=0) for one in (window.torque, *rates)])

    def _missed(self, window: Window, sudden: FloatArray, torque: FloatArray) -> Missed:
        found = self._here.design
        return Missed(
            stamp=window.stamp,
            sudden=np.mean(sudden[window.measured] ** 2, axis=0) / found.spread**2,
            slow=np.mean(torque**2, axis=0) / found.torque_spread**2,
            torque=np.stack([torque.mean(axis=0), np.sqrt(np.mean(torque**2, axis=0))]),
            motion=self._motion(window),
            sudden_part=sudden,
            design=found,
        )
