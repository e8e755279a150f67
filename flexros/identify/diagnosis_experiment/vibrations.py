"""The periodic parts of a diagnosis experiment: small slow reversals and multisines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.diagnosis_experiment.response import torque_response
from flexros.identify.excitation.lines import candidate_lines, spread, with_detection
from flexros.trajectory.vibration import Vibration

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.diagnosis_experiment.scales import Scales
    from flexros.robot import Robot

FADE = 0.25
"""Time in which a vibration is faded in, and out [s] (chosen)."""
SLOW_FADE = 0.6
"""The same for slow reversals, which would jerk otherwise [s] (chosen)."""
SLOW = 1.0
"""Frequency of the small slow reversals [Hz] (chosen)."""
SLOW_SHARE = 0.08
"""Largest acceleration of the slow reversals as a share of that of a move [1] (chosen)."""
APART = 0.17
"""How much faster every further motor reverses, so that motors meet in all directions [Hz] (chosen)."""
DETECTION_GROUP = 4
"""Of so many neighbouring odd lines one stays empty [1] (chosen)."""
PEAK_SHARE = 0.8
"""Largest torque of a vibration between its fades as a share of the torque scale [1] (chosen)."""
WAY_SHARE = 0.5
"""Largest way of a vibration as a share of the reach [1] (chosen: the other half is for the poses)."""
MOST_LINES = 120
"""Most lines of a multisine before detection lines are left out, spread evenly over its band [1] (chosen)."""
NYQUIST_SHARE = 0.45
"""Highest line that is possible as a share of the sampling rate [1] (chosen)."""
BAND = 0.06
"""Highest line as a share of the sampling rate [1] (chosen: 120 Hz at 2 kHz)."""


@dataclass(frozen=True, eq=False)
class Vibrations:
    """Maker of the periodic parts for one robot.

    Attributes:
        robot: The nominal robot.
        arm: Arm coordinates at the start [rad or m], shape (N,).
        law: The feedback controller.
        sample_time: Time between two samples [s].
        scales: Sizes of the motion.
    """

    robot: Robot
    arm: FloatArray
    law: AbstractControlLaw
    sample_time: float
    scales: Scales

    def slow(self, centre: FloatArray, duration: float, size: FloatArray, random: np.random.Generator) -> Vibration:
        """Make slow reversals of one size.

        Args:
            centre: Gear angles about which it moves [rad or m], shape (M,).
            duration: Time [s].
            size: Amplitudes, less where they would cost more than a small torque [rad or m], shape (M,).
            random: Source of the phases.

        Returns:
            A sine for every motor, each a little faster than the one before.
        """
        m = len(centre)
        frequency: FloatArray = (SLOW + APART * np.arange(m, dtype=np.float64)) * max(1.0, 2.0 / duration)
        size = np.minimum(size, SLOW_SHARE * self.scales.acceleration / (2.0 * np.pi * frequency) ** 2)
        phase = np.diag(random.uniform(0.0, 2.0 * np.pi, m))
        return Vibration(centre, frequency, np.diag(size), phase, duration, min(SLOW_FADE, 0.4 * duration))

    def multisine(
        self,
        centre: FloatArray,
        duration: float,
        level: float,
        random: np.random.Generator,
        band: tuple[float | None, float | None] = (None, None),
        bias: float = 0.0,
    ) -> Vibration:
        """Make an odd multisine with random phases and empty detection lines, two periods between its fades.

        All excited lines have the same amplitude of torque in the closed loop of the nominal robot. With a bias the
        first line is a slow swing of its own size, which keeps the transmitted torque on one side for most of the time.

        Args:
            centre: Gear angles about which it moves [rad or m], shape (M,).
            duration: Time [s].
            level: Rms torque as a share of the torque scale [1].
            random: Source of lines and phases.
            band: Lowest and highest line [Hz]; default: the lowest of the period, and a share of the sampling rate.
            bias: Peak torque of the swing as a share of the torque scale [1].

        Returns:
            The vibration.
        """
        period = duration / 3.0 if bias else 0.5 * duration - FADE
        period = round(period / self.sample_time) * self.sample_time
        fade = 0.5 * period if bias else FADE  # a faster fade of the swing would cost more torque than the swing
        lowest, highest = band
        top = BAND / self.sample_time if highest is None else min(highest, NYQUIST_SHARE / self.sample_time)
        lines = candidate_lines(max(3.0, (lowest or 0.0) * period), top * period, True, "diagnosis: the band")
        lines = with_detection(spread(lines, MOST_LINES, False), DETECTION_GROUP, random)
        lines = np.concatenate([[1], lines])
        frequency = lines / period
        response = torque_response(self.robot, self.arm, self.law, self.sample_time, self.scales, frequency)
        shape = np.full(len(lines), np.sqrt(2.0 / len(lines)) * level)
        shape[0] = max(shape[0], bias)
        own = np.abs(np.diagonal(response, axis1=1, axis2=2)).T  # (M, F)
        amplitude = self.scales.torque[:, None] * shape / own
        phase = random.uniform(0.0, 2.0 * np.pi, amplitude.shape)
        factor = self._room(response, amplitude * np.exp(1j * phase), lines, period)
        return Vibration(centre, frequency, factor[:, None] * amplitude, phase, 2.0 * period + 2.0 * fade, fade)

    def _room(self, response: ComplexArray, wave: ComplexArray, lines: IntArray, period: float) -> FloatArray:
        """Factors by which the amplitudes shrink to keep torque, speed and reach, shape (M,)."""
        w = 2.0 * np.pi * lines / period
        torque = np.einsum("fij,jf->if", response, wave)
        peak, speed, way = (_peak(part, lines) for part in (torque, 1j * w * wave, wave))
        room = np.minimum(self.scales.speed / speed, WAY_SHARE * self.scales.reach / way)
        room = np.minimum(room, np.min(PEAK_SHARE * self.scales.torque / peak))
        result: FloatArray = np.minimum(room, 1.0)
        return result


def _peak(wave: ComplexArray, lines: IntArray) -> FloatArray:
    """Largest size of sums of cosines over a period, shape (M,), from amplitudes and phases, shape (M, F)."""
    n = 8 * int(lines[-1])
    spectrum = np.zeros((len(wave), n // 2 + 1), dtype=complex)
    spectrum[:, lines] = 0.5 * n * wave
    peak: FloatArray = np.max(np.abs(np.fft.irfft(spectrum, n, axis=1)), axis=1)
    return peak
