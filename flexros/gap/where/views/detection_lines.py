"""Linear and nonlinear gaps in logs with periodic excitation, separated by excited and detection lines.

Over whole periods of an odd multisine in steady state, prediction errors at excited lines measure the difference
between the frequency responses of robot and model, as the predictor sees them. Lines that are not excited hold noise
alone unless there is a nonlinearity: odd lines for a symmetric one, even lines for one that is not (Schoukens,
Pintelon, Dobrowiecki & Rolain 2005). Noise is the difference between periods.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.stats import f as f_distribution

from flexros.gap.where.base import AbstractTestedView, Location

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.gap.where.prediction_errors import PredictionErrors
    from flexros.record.periodic_parts import PeriodicPart

POOL = 10
"""Neighbours on either side over which the noise of a line is averaged (chosen)."""
KINDS = ("excited lines", "odd detection lines", "even detection lines")
"""Names of the signals."""


class DetectionLines(AbstractTestedView):
    """Excess at excited and detection lines of each multisine and motor, tested against the noise between periods."""

    name: ClassVar[str] = "detection_lines"
    rank: ClassVar[int] = 5
    words: ClassVar[Mapping[str, str]] = MappingProxyType(
        {kind: f"excess of the multisines, at {kind}" for kind in KINDS}
    )

    @classmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Location]:
        """List a location per periodic part, motor and kind of lines; shares refer to all lines of all parts.

        The p-values are those of F tests times the number of tests (Bonferroni).
        """
        record, values = errors.record, errors.prediction.innovations
        levels = [line_levels(values, record.valid, part, record.sample_time) for part in record.parts]
        tests = [
            test
            for part, known in enumerate(levels)
            if known is not None
            for kind in range(len(KINDS))
            for test in _tests(part, known, kind, record.predicted)
        ]
        whole = max(sum(test.excess for test in tests), 1e-300)
        joints, least_share = errors.robot.joint_names, errors.settings.least_share
        return [test.location(joints, whole, len(tests), least_share) for test in tests]


@dataclass(frozen=True, eq=False)
class _Test:
    """Test of the lines of one kind of one part and motor; excess [(rad or m)^2], p-value of the F test alone."""

    part: int
    levels: LineLevels
    kind: int
    motor: int
    excess: float
    p_value: float

    def location(self, joints: Sequence[str], whole: float, n_tests: int, least_share: float) -> Location:
        """Return the location with its share in the whole excess and its corrected p-value."""
        frequency = self.levels.frequency
        return Location(
            signal=KINDS[self.kind],
            joint=joints[self.motor],
            band_hz=(float(frequency[0]), float(frequency[-1])),
            regime=f"multisine {self.part + 1}",
            kind="multisine",
            share=self.excess / whole,
            expected=1.0 / n_tests,
            p_value=min(1.0, self.p_value * n_tests),
            least_share=least_share,
            mapped=False,
        )


def _tests(part: int, levels: LineLevels, kind: int, predicted: BoolArray) -> list[_Test]:
    """Test the lines of one kind for each motor that is predicted."""
    lines = levels.kind == kind
    if not lines.any():
        return []
    power, noise = levels.power[lines].sum(axis=0), levels.noise[lines].sum(axis=0)
    freedom = 2 * int(lines.sum())
    p_values = f_distribution.sf(power / np.maximum(noise, 1e-300), freedom, freedom * (levels.n_periods - 1))
    return [
        _Test(part, levels, kind, motor, max(float(power[motor] - noise[motor]), 0.0), float(p_value))
        for motor, p_value in enumerate(p_values)
        if predicted[motor]
    ]


@dataclass(frozen=True, eq=False)
class LineLevels:
    """Prediction errors of one periodic part by line.

    Attributes:
        frequency: Lines from the lowest to the highest excited one [Hz], shape (L,).
        kind: Index in `KINDS` of each line, shape (L,).
        power: Power of the mean over the periods [(rad or m)^2], shape (L, M).
        noise: Part of it that is noise [(rad or m)^2], shape (L, M).
        n_periods: Number of periods.
    """

    frequency: FloatArray
    kind: IntArray
    power: FloatArray
    noise: FloatArray
    n_periods: int

    @property
    def distance(self) -> FloatArray:
        """Size of the errors in standard deviations of the noise, averaged over neighbouring lines, shape (L, M)."""
        window = np.ones(2 * POOL + 1)
        count = np.convolve(np.ones(len(self.noise)), window, "same")[:, None]
        pooled = np.array([np.convolve(column, window, "same") for column in self.noise.T]).T / count
        return np.asarray(np.sqrt(self.power / np.maximum(pooled, 1e-300)))


def line_levels(errors: FloatArray, valid: BoolArray, part: PeriodicPart, sample_time: float) -> LineLevels | None:
    """Compute the power of prediction errors and of their noise by line.

    Args:
        errors: Prediction errors [rad or m], shape (n, M).
        valid: Samples that were measured, shape (n,).
        part: The periodic part.
        sample_time: Time between two samples [s].

    Returns:
        The levels; None where samples are missing.
    """
    if part.end > len(errors) or not valid[part.first : part.end].all():
        return None
    cut = errors[part.first : part.end].reshape(part.n_periods, part.period, -1)
    lines = np.arange(part.lines[0], part.lines[-1] + 1)
    spectra = 2 / part.period * np.fft.rfft(cut, axis=1)[:, lines]
    mean = spectra.mean(axis=0)
    noise = (np.abs(spectra - mean) ** 2).sum(axis=0) / (part.n_periods - 1) / part.n_periods
    kind = np.where(np.isin(lines, part.lines), 0, np.where(lines % 2 == 1, 1, 2))
    return LineLevels(lines / (part.period * sample_time), kind, np.abs(mean) ** 2, noise, part.n_periods)
