"""Transforms of whole periods."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.estimate.period_spectra import amplitudes


def test_cosine_has_its_amplitude_and_phase_in_every_period() -> None:
    n = np.arange(300)
    samples = 3.0 * np.cos(2 * np.pi * 7 * n / 100 + 0.4)[:, None]
    spectra = amplitudes(samples, 3, np.array([5, 7]))
    assert spectra.shape == (3, 2, 1)
    np.testing.assert_allclose(spectra[:, 1, 0], 3.0 * np.exp(0.4j))
    np.testing.assert_allclose(spectra[:, 0, 0], 0, atol=1e-13)


def test_record_that_is_no_whole_periods_is_refused() -> None:
    with pytest.raises(InputError, match="a record of 101 samples cannot be 2 whole periods; cut it"):
        amplitudes(np.zeros((101, 1)), 2, np.array([1]))


def test_line_at_the_nyquist_frequency_is_refused() -> None:
    with pytest.raises(InputError, match="aliasing: line 50 of a period of 100 samples is outside of 0 to 49"):
        amplitudes(np.zeros((100, 1)), 1, np.array([1, 50]))


def test_no_line_is_refused() -> None:
    with pytest.raises(InputError, match="no line is excited"):
        amplitudes(np.zeros((100, 1)), 1, np.array([], dtype=np.int64))
