"""Phases with low peaks."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.excitation.crest_factor import low_crest_phases
from flexros.identify.excitation.multisine import synthesise
from tests.identify.excitation.crest import crest_factor

LINES = np.arange(3, 81, 2)


def sizes_and_phases() -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(5)
    return random.uniform(0.5, 1.5, (2, len(LINES))), random.uniform(0.0, 2.0 * np.pi, (2, len(LINES)))


def test_amplitudes_stay_and_peaks_sink() -> None:
    size, phases = sizes_and_phases()
    improved = low_crest_phases(LINES, size, phases, 200, np.array([False, False]))
    before, after = (synthesise(LINES, size, p[None], 2000, 1e-3).speed[0] for p in (phases, improved))
    np.testing.assert_allclose(np.abs(np.fft.rfft(after, axis=0)), np.abs(np.fft.rfft(before, axis=0)), atol=1e-9)
    assert np.all(crest_factor(before) > 2.3)
    assert np.all(crest_factor(after) < 1.7)


def test_low_envelope_bounds_the_signal_at_every_common_phase() -> None:
    size, phases = sizes_and_phases()
    improved = low_crest_phases(LINES, size, phases, 300, np.array([True, True]))
    turned = improved + np.linspace(0.0, 2.0 * np.pi, 24)[:, None, None]
    worst = np.max(crest_factor(np.moveaxis(synthesise(LINES, size, turned, 2000, 1e-3).speed, 1, 0)))
    assert worst < 1.9
    only_signal = low_crest_phases(LINES, size, phases, 300, np.array([False, False]))
    turned = only_signal + np.linspace(0.0, 2.0 * np.pi, 24)[:, None, None]
    assert np.max(crest_factor(np.moveaxis(synthesise(LINES, size, turned, 2000, 1e-3).speed, 1, 0))) > worst


def test_without_iterations_the_phases_stay() -> None:
    size, phases = sizes_and_phases()
    assert np.array_equal(low_crest_phases(LINES, size, phases, 0, np.array([True, False])), phases)


@pytest.mark.parametrize("envelope", [True, False])
def test_a_motor_without_excitation_does_no_harm(envelope: bool) -> None:
    size, phases = sizes_and_phases()
    size[0] = 0.0
    improved = low_crest_phases(LINES, size, phases, 10, np.array([envelope, envelope]))
    assert np.all(np.isfinite(improved))
