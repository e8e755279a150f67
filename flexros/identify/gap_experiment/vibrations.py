"""The periodic parts of a diagnosis experiment: small slow reversals and multisines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.excitation.lines import candidate_lines, with_detection
from flexros.identify.gap_experiment.response import torque_response
from flexros.trajectory.vibration import Vibration

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.gap_experiment.scales import Scales
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
        highest: float | None = None,
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
            highest: Highest line [Hz]; default: a share of the sampling rate.
            bias: Peak torque of the swing as a share of the torque scale [1].

        Returns:
            The vibration.
        """
        period = duration / 3.0 if bias else 0.5 * duration - FADE
        period = round(period / self.sample_time) * self.sample_time
        fade = 0.5 * period if bias else FADE  # a faster fade of the swing would cost more torque than the swing
        top = BAND / self.sample_time if highest is None else min(highest, 0.45 / self.sample_time)
        lines = with_detection(candidate_lines(3.0, top * period, True, "diagnosis"), DETECTION_GROUP, random)
        lines = np.concatenate([[1], lines])
        frequency = lines / period
        response = torque_response(self.robot, self.arm, self.law, self.sample_time, self.scales, frequency)
        shape = np.full(len(lines), np.sqrt(2.0 / len(lines)) * level)
        shape[0] = max(shape[0], bias)
        own = np.abs(np.diagonal(response, axis1=1, axis2=2)).T  # (M, F)
        amplitude = self.scales.torque[:, None] * shape / own
        phase = random.uniform(0.0, 2.0 * np.pi, amplitude.shape)
        factor = self._room(response, amplitude, phase, frequency)
        return Vibration(centre, frequency, factor[:, None] * amplitude, phase, 2.0 * period + 2.0 * fade, fade)

    def _room(
        self, response: ComplexArray, amplitude: FloatArray, phase: FloatArray, frequency: FloatArray
    ) -> FloatArray:
        """Factors by which the amplitudes shrink to keep torque, speed and reach, shape (M,)."""
        wave = amplitude * np.exp(1j * phase)
        w = 2.0 * np.pi * frequency
        period = 1.0 / frequency[0]
        time = np.arange(0.0, period, 0.25 / frequency[-1])
        turned = np.exp(1j * w[:, None] * time)
        peak = np.max(np.abs((np.einsum("fij,jf->if", response, wave) @ turned).real), axis=1)
        speed = np.max(np.abs(((1j * w * wave) @ turned).real), axis=1)
        way = np.max(np.abs((wave @ turned).real), axis=1)
        room = np.minimum(self.scales.speed / speed, 0.5 * self.scales.reach / way)
        room = np.minimum(room, np.min(PEAK_SHARE * self.scales.torque / peak))
        result: FloatArray = np.minimum(room, 1.0)
        return result
