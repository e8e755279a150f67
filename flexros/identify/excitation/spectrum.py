"""Amplitude spectra of an excitation."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np
from pydantic import AfterValidator, Field

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

Point: TypeAlias = tuple[Annotated[float, Field(gt=0.0)], Annotated[float, Field(gt=0.0)]]
"""Frequency [Hz] and relative amplitude [1]."""


def _increasing(points: tuple[Point, ...]) -> tuple[Point, ...]:
    frequencies = [frequency for frequency, _ in points]
    if any(low >= high for low, high in pairwise(frequencies)):
        raise ValueError(f"the frequencies of the spectrum are {frequencies}, allowed are increasing ones; sort them")
    return points


Spectrum: TypeAlias = Literal["flat"] | Annotated[tuple[Point, ...], Field(min_length=1), AfterValidator(_increasing)]
"""Equal amplitudes, or points [[Hz, relative amplitude], ...]."""


def amplitudes(spectrum: Spectrum, frequency: FloatArray, rms: FloatArray) -> FloatArray:
    """Return the amplitude of every line.

    The amplitude is interpolated linearly on double logarithmic axes and constant beyond the end points.

    Args:
        spectrum: Shape of the spectrum.
        frequency: Excited frequencies [Hz], shape (F,).
        rms: Root mean square of the whole signal of every motor, shape (M,).

    Returns:
        Amplitudes A with sum_k A_k^2 / 2 = rms^2, shape (M, F).
    """
    if spectrum == "flat":
        shape = np.ones(len(frequency))
    else:
        points = np.log(np.array(spectrum, dtype=float))
        shape = np.exp(np.interp(np.log(frequency), points[:, 0], points[:, 1]))
    result: FloatArray = rms[:, None] * shape * np.sqrt(2.0 / np.sum(shape**2))
    return result
