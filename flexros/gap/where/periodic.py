"""Parts of a log with periodic excitation: linear and nonlinear gaps told apart by the lines at which errors lie.

Prediction errors answer what the model lacks. Over whole periods of an odd multisine in steady state, those at excited
lines measure how far the frequency responses of robot and model are apart, as the predictor sees them; at lines that
are not excited there is noise alone, unless something is nonlinear: at odd ones where it is symmetric, at even ones
where it is not (Schoukens, Pintelon, Dobrowiecki & Rolain 2005). Noise is what differs from period to period.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import f as f_distribution

from flexros.gap.schema import Excess

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.periodic_parts import PeriodicPart

POOL = 10
"""Neighbours on either side over which the noise of a line is averaged (chosen)."""
KINDS = ("excited lines", "odd detection lines", "even detection lines")
"""Names of the signals."""


@dataclass(frozen=True, eq=False)
class LineLevels:
    """Prediction errors of one part line by line.

    Attributes:
        frequency: Lines from the lowest to the highest excited one [Hz], shape (L,).
        kind: Number in `KINDS` of each line, shape (L,).
        power: Power of the mean over the periods [(rad or m)^2], shape (L, M).
        noise: What noise has of it [(rad or m)^2], shape (L, M).
        n_periods: Number of periods.
    """

    frequency: FloatArray
    kind: IntArray
    power: FloatArray
    noise: FloatArray
    n_periods: int

    @property
    def distance(self) -> FloatArray:
        """Size of the errors in standard deviations of noise, that averaged over neighbours, shape (L, M)."""
        window = np.ones(2 * POOL + 1)
        count = np.convolve(np.ones(len(self.noise)), window, "same")[:, None]
        pooled = np.array([np.convolve(column, window, "same") for column in self.noise.T]).T / count
        return np.asarray(np.sqrt(self.power / np.maximum(pooled, 1e-300)))


def line_levels(errors: FloatArray, valid: BoolArray, part: PeriodicPart, sample_time: float) -> LineLevels | None:
    """Tell prediction errors apart by lines.

    Args:
        errors: Prediction errors [rad or m], shape (n, M).
        valid: Samples that were measured, shape (n,).
        part: Where the periods are.
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


def periodic_places(
    errors: FloatArray, valid: BoolArray, parts: Sequence[PeriodicPart], sample_time: float, joints: Sequence[str]
) -> tuple[Excess, ...]:
    """Test whether there is more than noise at excited and at detection lines.

    The p-values are those of F tests times the number of tests (Bonferroni), so that many looks raise no alarm.

    Args:
        errors: Prediction errors [rad or m], shape (n, M).
        valid: Samples that were measured, shape (n,).
        parts: The periodic parts of the log.
        sample_time: Time between two samples [s].
        joints: Names of the motors, length M.

    Returns:
        A place per part, motor and kind of lines, with its share of the excess at all lines of all parts.
    """
    found = [(part, line_levels(errors, valid, part, sample_time)) for part in parts]
    known = [(number, levels) for number, (_, levels) in enumerate(found) if levels is not None]
    entries = []
    for number, levels in known:
        for kind in range(len(KINDS)):
            mine = levels.kind == kind
            if not mine.any():
                continue
            power, noise = levels.power[mine].sum(axis=0), levels.noise[mine].sum(axis=0)
            freedom = 2 * int(mine.sum())
            p = f_distribution.sf(power / np.maximum(noise, 1e-300), freedom, freedom * (levels.n_periods - 1))
            entries += [
                (number, levels, kind, joint, max(float(power[m] - noise[m]), 0.0), float(p[m]))
                for m, joint in enumerate(joints)
            ]
    whole = max(sum(entry[4] for entry in entries), 1e-300)
    return tuple(
        Excess(
            signal=KINDS[kind],
            joint=joint,
            band_hz=(round(float(levels.frequency[0]), 3), round(float(levels.frequency[-1]), 3)),
            regime=f"multisine {number + 1}",
            share=excess / whole,
            p_value=min(1.0, p * len(entries)),
        )
        for number, levels, kind, joint, excess, p in entries
    )
