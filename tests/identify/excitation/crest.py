"""Crest factor of a signal."""

from __future__ import annotations

import numpy as np


def crest_factor(signal: np.ndarray) -> np.ndarray:
    """Return the ratio of peak to root mean square along the first axis."""
    return np.max(np.abs(signal), axis=0) / np.sqrt(np.mean(signal**2, axis=0))
