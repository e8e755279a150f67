"""Observer model and disturbance filter, window by window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.monitor.design_book import DesignBook
from flexros.monitor.observer_model import ObserverModel
from flexros.record.missing_samples import bridged

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.monitor.design import Design
    from flexros.monitor.design_book import PoseDesign
    from flexros.monitor.sample_stream import Window

CORRECTIONS = 5
"""Corrections of the observer state by its filter after a start in motion (chosen)."""
BETWEEN = 2.0
"""Time between them, in time constants of the filter: each reduces an error to a seventh (chosen)."""
AT_REST = 3.0
"""Time to converge after a start at rest, in time constants of the filter (chosen)."""
PARTS = 4
"""Parts of a window whose mean positions give speeds and accelerations (chosen)."""
STAYS = 1.0
"""Shortest time with one design [s]; computing one takes about 40 ms for six axes (chosen)."""


@dataclass(frozen=True, eq=False)
class WindowResult:
    """Result of a window.

    Attributes:
        stamp: Stamp of the first sample [ns].
        innovation: Mean square of the innovations over that of noise [1], shape (M,).
        disturbance: Mean square of the disturbance torques over that of noise [1], shape (M,).
        torque: Disturbance torque, mean and rms [Nm or N], shape (2, M).
        motion: Mean squares of torques, speeds and accelerations of the motors [SI], shape (3 M,).
        innovations: Innovations of the filter [rad or m], shape (samples, M).
        design: Design in use.
    """

    stamp: int
    innovation: FloatArray
    disturbance: FloatArray
    torque: FloatArray
    motion: FloatArray
    innovations: FloatArray
    design: Design


class Watch:
    """Runs the observer model and its filter.

    Args:
        model: The nominal model.
        sample_time: Time between two samples [s].
        samples: Samples of a window.

    Attributes:
        sample_time: Time between two samples [s].
        book: Designs for poses.
        settling: Whether the observer is still converging.
        runaways: Number of times that it diverged.
    """

    def __init__(self, model: RobotWithEffects, sample_time: float, samples: int) -> None:
        self.book = DesignBook(model, sample_time, samples)
        self._observer = ObserverModel(model, sample_time)
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

    def take(self, window: Window) -> WindowResult | None:
        """Evaluate the next window.

        Args:
            window: The window.

        Returns:
            The result; None while the observer converges.
        """
        try:
            if window.restarted or not self._running:
                self._begin(window)
            self._follow_pose(window.position[0])
            errors = self._observer.run(window, self.book.gain)
        except (InputError, np.linalg.LinAlgError):  # no equilibrium, or no filter, at these positions
            errors = None
        if errors is None:
            self.runaways += 1
            self._running, self.settling = False, True
            return None
        if not window.measured.all():
            errors = bridged(errors, window.measured)
        innovations, torque = self._filtered(errors)
        if self.settling:
            self._settle()
            return None
        return self._result(window, innovations, torque)

    def _begin(self, window: Window) -> None:
        self._observer.begin(window)
        self._cell = self.book.cell(window.position[0])
        self._here = self.book.at(self._cell)
        self._since_design = 0
        self._state = np.zeros(len(self._here.lifted.A))
        self._corrections = CORRECTIONS if self._observer.starts_in_motion else 0
        self._wait = self._windows(BETWEEN if self._corrections else AT_REST)
        self._running = self.settling = True

    def _windows(self, time_constants: float) -> int:
        return int(np.ceil(time_constants * self._here.design.settling / self._samples))

    def _follow_pose(self, position: FloatArray) -> None:
        """Change to the design of another cell, not too often."""
        self._since_design += 1
        if self._since_design >= self._stay or self.settling:
            cell = self.book.cell(position)
            if cell != self._cell:
                self._cell, self._here, self._since_design = cell, self.book.at(cell), 0

    def _filtered(self, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Filter errors: innovations, shape (samples, M), and disturbance torques, shape (blocks, M)."""
        lifted, M = self._here.lifted, errors.shape[1]
        outputs = np.empty((self._samples // self.book.block, self.book.block, 2 * M))
        for number, block in enumerate(errors.reshape(-1, self.book.block * M)):
            outputs[number] = (lifted.C @ self._state + lifted.D @ block).reshape(self.book.block, 2 * M)
            self._state = lifted.A @ self._state + lifted.B @ block
        return outputs[:, :, :M].reshape(-1, M), outputs[:, -1, M:]

    def _settle(self) -> None:
        """Correct the observer state by its filter, after the time that the filter needs."""
        self._wait -= 1
        if self._wait > 0:
            return
        if self._corrections == 0:
            self.settling = False
            return
        robot = len(self.book.gain)
        self._observer.correct(self._state[:robot])
        self._state[:robot] = 0.0
        self._corrections -= 1
        self._wait = self._windows(BETWEEN)

    def _motion(self, window: Window) -> FloatArray:
        """Return the mean squares of torques, speeds and accelerations, shape (3 M,)."""
        number = min(PARTS, len(window.position))
        step = self.sample_time * self._samples / number
        position = np.array([part.mean(axis=0) for part in np.array_split(window.position, number)])
        rates = [np.diff(position, order, axis=0) / step**order for order in (1, 2)]
        return np.concatenate([(signal**2).sum(axis=0) / max(len(signal), 1) for signal in (window.torque, *rates)])

    def _result(self, window: Window, innovations: FloatArray, torque: FloatArray) -> WindowResult:
        design = self._here.design
        return WindowResult(
            stamp=window.stamp,
            innovation=np.mean(innovations[window.measured] ** 2, axis=0) / design.spread**2,
            disturbance=np.mean(torque**2, axis=0) / design.torque_spread**2,
            torque=np.stack([torque.mean(axis=0), np.sqrt(np.mean(torque**2, axis=0))]),
            motion=self._motion(window),
            innovations=innovations,
            design=design,
        )
