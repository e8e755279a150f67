"""The periodic parts of a diagnosis experiment: small slow reversals and multisines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.control.context import LoopContext
from flexros.identify.excitation.lines import candidate_lines, spread, with_detection
from flexros.identify.experiment.closed_loop_response import ControllerResponse, controller_response, loop_response
from flexros.trajectory.vibration import Vibration

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.diagnosis_experiment.scales import Scales
    from flexros.robot import Robot

FADE = 0.25
"""Fade-in and fade-out time of a vibration [s] (chosen)."""
SLOW_FADE = 0.6
"""The same for slow reversals, which would otherwise jerk [s] (chosen)."""
SLOW = 1.0
"""Frequency of the small slow reversals [Hz] (chosen)."""
SLOW_SHARE = 0.08
"""Largest acceleration of the slow reversals as a share of that of a move [1] (chosen)."""
APART = 0.17
"""Increase of the frequency from motor to motor, so that motors meet in all combinations of direction [Hz] (chosen)."""
DETECTION_GROUP = 4
"""Group size of neighbouring odd lines of which one stays empty [1] (chosen)."""
PEAK_SHARE = 0.8
"""Largest torque of a vibration between its fades as a share of the torque scale [1] (chosen)."""
STROKE_SHARE = 0.5
"""Largest stroke of a vibration as a share of the reach [1] (chosen: the other half is for the poses)."""
MOST_LINES = 120
"""Largest number of lines of a multisine including detection lines, spread evenly over its band [1] (chosen)."""
NYQUIST_SHARE = 0.45
"""Highest possible line as a share of the sampling rate [1] (chosen)."""
BAND = 0.06
"""Default highest line as a share of the sampling rate [1] (chosen: 120 Hz at 2 kHz)."""


@dataclass(frozen=True, eq=False)
class Vibrations:
    """Factory of the periodic parts for one robot.

    Attributes:
        robot: The nominal robot.
        arm: Initial arm coordinates [rad or m], shape (N,).
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
        """Compute slow reversals of one size: a sine for every motor, each slightly faster than the previous one.

        Args:
            centre: Gear angles of the centre [rad or m], shape (M,).
            duration: Duration [s].
            size: Amplitudes, reduced where they would need more than a small torque [rad or m], shape (M,).
            random: Random generator of the phases.
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
        """Compute an odd multisine with random phases and empty detection lines, two periods between its fades.

        All excited lines have the same amplitude of torque in the closed loop of the nominal robot. With a bias the
        first line is a slow swing of its own size, which keeps the transmitted torque on one side for most of the time.

        Args:
            centre: Gear angles of the centre [rad or m], shape (M,).
            duration: Duration [s].
            level: Rms torque as a share of the torque scale [1].
            random: Random generator of lines and phases.
            band: Lowest and highest line [Hz]; default: the lowest of the period, and a share of the sampling rate.
            bias: Peak torque of the swing as a share of the torque scale [1].
        """
        period = duration / 3.0 if bias else 0.5 * duration - FADE
        period = round(period / self.sample_time) * self.sample_time
        fade = 0.5 * period if bias else FADE  # a faster fade of the swing would need more torque than the swing
        lowest, highest = band
        top = BAND / self.sample_time if highest is None else min(highest, NYQUIST_SHARE / self.sample_time)
        lines = candidate_lines(max(3.0, (lowest or 0.0) * period), top * period, True, "diagnosis: the band")
        lines = with_detection(spread(lines, MOST_LINES, False), DETECTION_GROUP, random)
        lines = np.concatenate([[1], lines])
        frequency = lines / period
        response = torque_response(self.robot, self.arm, self.law, self.sample_time, self.scales, frequency)
        shape = np.full(len(lines), np.sqrt(2.0 / len(lines)) * level)
        shape[0] = max(shape[0], bias)
        gain = np.abs(np.diagonal(response, axis1=1, axis2=2)).T  # (M, F)
        amplitude = self.scales.torque[:, None] * shape / gain
        phase = random.uniform(0.0, 2.0 * np.pi, amplitude.shape)
        factor = self._scaling(response, amplitude * np.exp(1j * phase), lines, period)
        return Vibration(centre, frequency, factor[:, None] * amplitude, phase, 2.0 * period + 2.0 * fade, fade)

    def _scaling(self, response: ComplexArray, motion: ComplexArray, lines: IntArray, period: float) -> FloatArray:
        """Factors that reduce the amplitudes to keep torque, speed and reach, shape (M,)."""
        w = 2.0 * np.pi * lines / period
        torque = np.einsum("fij,jf->if", response, motion)
        peak, speed, stroke = (_peak(part, lines) for part in (torque, 1j * w * motion, motion))
        factor = np.minimum(self.scales.speed / speed, STROKE_SHARE * self.scales.reach / stroke)
        factor = np.minimum(factor, np.min(PEAK_SHARE * self.scales.torque / peak))
        result: FloatArray = np.minimum(factor, 1.0)
        return result


def torque_response(
    robot: Robot, arm: FloatArray, law: AbstractControlLaw, sample_time: float, scales: Scales, frequency: FloatArray
) -> ComplexArray:
    """Return the response from motor reference to torque command, including the feedforward of the rigid robot.

    Args:
        robot: The nominal robot.
        arm: Arm coordinates at rest [rad or m], shape (N,).
        law: The feedback controller.
        sample_time: Time between two samples [s].
        scales: Sizes, with the inertia of the rigid robot.
        frequency: Frequencies [Hz], shape (F,).

    Returns:
        The response [Nm/rad or N/m], shape (F, M, M).
    """
    m, s = robot.n_motors, 2j * np.pi * frequency[:, None, None]
    feedback = controller_response(law, LoopContext(robot, sample_time), frequency)
    position, speed = feedback.to_reference[:, :, :m], feedback.to_reference[:, :, m:]
    whole = position + s * speed + s**2 * scales.inertia
    both = np.concatenate([whole, np.zeros_like(whole)], axis=2)
    response = loop_response(robot, arm, ControllerResponse(both, feedback.to_measured), sample_time, frequency)
    return response.torque[:, :, :m]


def _peak(amplitudes: ComplexArray, lines: IntArray) -> FloatArray:
    """Peak of sums of cosines over a period, shape (M,), from complex amplitudes, shape (M, F)."""
    n = 8 * int(lines[-1])
    spectrum = np.zeros((len(amplitudes), n // 2 + 1), dtype=complex)
    spectrum[:, lines] = 0.5 * n * amplitudes
    peak: FloatArray = np.max(np.abs(np.fft.irfft(spectrum, n, axis=1)), axis=1)
    return peak
