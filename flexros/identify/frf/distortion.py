"""Levels of noise, of odd and even nonlinear distortion and of time variation over frequency."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from flexros.identify.frf.quantity import differentiation

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Distortion:
    """Levels of the outputs that a linear, time-invariant, noise-free system would not show.

    Every level is the rms amplitude of a sinusoid at one line, referred to the output: the response to the torque at
    that line, by the best linear approximation, is subtracted (Schoukens et al. 2005; closed loop).

    Attributes:
        frequency: Excited lines [Hz], shape (F,).
        output: Amplitude of the output [unit of the quantity], shape (F, n_y); the level to compare with.
        noise: Noise of the mean over the periods of an experiment, shape (F, n_y); NaN where there is one period only.
        total: Noise and stochastic nonlinear distortion, from blocks, shape (F, n_y); NaN with one block only.
        time_variation: Change from period to period beyond the noise at neighbouring lines, shape (F, n_y); NaN if
            unknown.
        odd_frequency: Odd detection lines [Hz], shape (D,).
        odd: Level at odd detection lines, shape (D, n_y).
        odd_noise: Noise there, shape (D, n_y).
        even_frequency: Even detection lines [Hz], shape (E,).
        even: Level at even detection lines, shape (E, n_y).
        even_noise: Noise there, shape (E, n_y).
    """

    frequency: FloatArray
    output: FloatArray
    noise: FloatArray
    total: FloatArray
    time_variation: FloatArray
    odd_frequency: FloatArray
    odd: FloatArray
    odd_noise: FloatArray
    even_frequency: FloatArray
    even: FloatArray
    even_noise: FloatArray

    def differentiated(self, order: int) -> Distortion:
        """Return the levels of the outputs differentiated `order` times (negative: integrated)."""
        at = {"odd": self.odd_frequency, "even": self.even_frequency}
        changed = {}
        for field in fields(self):
            value = getattr(self, field.name)
            if not field.name.endswith("frequency"):
                frequency = at.get(field.name.split("_")[0], self.frequency)
                value = value * abs(differentiation(frequency, order))[:, None]
            changed[field.name] = value
        return Distortion(**changed)
