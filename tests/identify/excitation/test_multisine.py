"""Orthogonal random-phase multisines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from flexros.arrays import ComplexArray
from flexros.errors import InputError
from flexros.identify.excitation.multisine import Multisine
from tests.identify.excitation.crest import crest_factor

pytestmark = pytest.mark.slow

T = 5e-4


def spectra(multisine: Multisine, n_motors: int, block: int = 0) -> ComplexArray:
    """Give the DFT of the speed, shape (lines, motors, experiments)."""
    signals = multisine.block(n_motors, T, 1, 0, block)
    return np.fft.rfft(signals.speed, axis=1).transpose(1, 2, 0)


@pytest.mark.parametrize("n_motors", [1, 2, 3, 6])
def test_spectra_of_a_block_are_orthogonal_at_every_excited_line(n_motors: int) -> None:
    multisine = Multisine(amplitude=0.3)
    U = spectra(multisine, n_motors)[multisine.lines(T, 1).excited]
    gram = U @ U.conj().swapaxes(1, 2)
    scale = gram[0, 0, 0].real
    np.testing.assert_allclose(gram, scale * np.broadcast_to(np.eye(n_motors), gram.shape), atol=1e-10 * scale)


def test_set_is_that_of_paper_a() -> None:
    multisine = Multisine()
    R = spectra(multisine, 6)[multisine.lines(T, 1).excited]
    numbers = np.arange(6)
    wanted = np.exp(2j * np.pi / 6 * np.outer(numbers, numbers))
    np.testing.assert_allclose(R / R[:, :, :1], np.broadcast_to(wanted, R.shape), atol=1e-9)


def test_only_the_excited_lines_have_energy() -> None:
    multisine = Multisine()
    U = np.abs(spectra(multisine, 6))
    excited = multisine.lines(T, 1).excited
    assert np.all(excited % 2 == 1)
    assert np.min(U[excited]) > 1.0
    assert np.max(np.delete(U, excited, axis=0)) < 1e-10


def test_detection_lines_are_empty_and_one_is_in_every_group() -> None:
    multisine = Multisine(detection_group=4)
    U, lines = np.abs(spectra(multisine, 2)), multisine.lines(T, 1)
    assert np.max(U[lines.odd_detection]) < 1e-10
    assert np.max(U[lines.even_detection]) < 1e-10
    together = np.sort(np.concatenate([lines.excited, lines.odd_detection]))
    assert np.array_equal(together, np.arange(3, 120, 2))
    assert all(np.isin(together[k : k + 4], lines.odd_detection).sum() == 1 for k in range(0, len(together) - 3, 4))
    assert np.array_equal(lines.even_detection, np.arange(4, 119, 2))


def test_group_of_nothing_but_the_ends_of_the_band_stays_whole() -> None:
    lines = Multisine(number=2, detection_group=2).lines(T, 1)
    assert np.array_equal(lines.excited, [3, 119])
    three = Multisine(number=3, detection_group=2).lines(T, 1)
    assert np.array_equal(three.excited, [3, 119])


def test_detection_lines_follow_from_the_seed() -> None:
    one, again, other = (Multisine().lines(T, seed).odd_detection for seed in (1, 1, 2))
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)


def test_every_block_and_position_has_new_phases() -> None:
    multisine = Multisine()
    here, next_block, elsewhere = (multisine.block(2, T, 1, *place).speed for place in ((0, 0), (0, 1), (1, 0)))
    assert np.max(np.abs(here - next_block)) > 0.5 * np.max(here)
    assert np.max(np.abs(here - elsewhere)) > 0.5 * np.max(here)
    assert np.array_equal(here, multisine.block(2, T, 1, 0, 0).speed)


def test_rms_is_that_asked_for_in_every_experiment() -> None:
    speed = Multisine(amplitude=(0.1, 0.3)).block(2, T, 1, 0, 0).speed
    np.testing.assert_allclose(np.sqrt(np.mean(speed**2, axis=1)), [[0.1, 0.3]] * 2, rtol=1e-12)


def test_position_is_the_exact_integral_of_the_speed_with_zero_mean() -> None:
    signals = Multisine(amplitude=0.1).block(3, T, 1, 0, 0)
    speed, position = (np.fft.rfft(part, axis=1) for part in (signals.speed, signals.position))
    rate = 2j * np.pi * np.fft.rfftfreq(signals.speed.shape[1], T)
    np.testing.assert_allclose(rate[None, :, None] * position, speed, atol=1e-10 * np.max(np.abs(speed)))
    assert np.max(np.abs(np.mean(signals.position, axis=1))) < 1e-16


def test_amplitudes_follow_the_spectrum() -> None:
    multisine = Multisine(spectrum=((2.0, 1.0), (20.0, 0.1)), detection_group=None)
    excited = multisine.lines(T, 1).excited
    size = np.abs(spectra(multisine, 1)[excited, 0, 0])
    frequency = excited / 2.0
    inside = (frequency > 2.0) & (frequency < 20.0)
    slope = np.polyfit(np.log(frequency[inside]), np.log(size[inside]), 1)[0]
    assert slope == pytest.approx(-1.0, abs=1e-9)
    np.testing.assert_allclose(size[frequency > 20.0] / size[0], 0.1, rtol=1e-9)


def test_iterations_lower_the_largest_crest_factor_of_the_whole_set() -> None:
    before, after = (
        np.max(crest_factor(np.moveaxis(Multisine(crest_iterations=n).block(6, T, 1, 0, 0).speed, 1, 0)))
        for n in (0, 200)
    )
    assert before > 2.7
    assert after < 1.95


def test_independent_experiments_have_phases_of_their_own() -> None:
    speed = Multisine(orthogonal=False).block(3, T, 1, 0, 0).speed
    assert abs(np.corrcoef(speed[0, :, 0], speed[1, :, 0])[0, 1]) < 0.6
    orthogonal = Multisine().block(3, T, 1, 0, 0).speed
    assert np.array_equal(orthogonal[0, :, 0], orthogonal[1, :, 0])  # T has a row of ones


def test_logarithmic_grid_has_odd_lines_spread_over_the_decades() -> None:
    lines = Multisine(grid="logarithmic", number=20, detection_group=None, period=10.0).lines(T, 1).excited
    assert np.all(lines % 2 == 1)
    assert (lines[0], lines[-1]) == (11, 599)
    np.testing.assert_allclose(np.diff(np.log(lines)), np.log(599 / 11) / 19, atol=0.12)


def test_all_lines_may_be_excited() -> None:
    lines = Multisine(lines_of="all", detection_group=None).lines(T, 1)
    assert np.array_equal(lines.excited, np.arange(2, 121))
    assert lines.odd_detection.size == lines.even_detection.size == 0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"highest": 1000.0}, r"excitation\.highest is 1000 Hz, allowed is less than half the sampling rate, 1000 Hz"),
        ({"period": 1.9999}, r"excitation\.period is 1\.9999 s, allowed is a whole number of samples of 0\.0005 s"),
        ({"lowest": 4.1, "highest": 4.2}, r"the band from 4\.1 to 4\.2 Hz .* no odd line of the period"),
    ],
)
def test_impossible_frequencies_are_named(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Multisine(**settings).lines(T, 1)


def test_band_and_spectrum_are_checked_when_read() -> None:
    with pytest.raises(ValidationError, match="highest is 1 Hz, allowed is lowest = 2 Hz or more"):
        Multisine(lowest=2.0, highest=1.0)
    with pytest.raises(ValidationError, match="allowed are increasing ones; sort them"):
        Multisine(spectrum=((2.0, 1.0), (1.0, 1.0)))
