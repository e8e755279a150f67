"""Disturbances over time, their places and their errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from flexros.errors import InputError
from flexros.simulate.disturbance import AbstractDisturbance, Disturbance, disturbance_signal

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

T = 5e-4


def make(**settings: Any) -> AbstractDisturbance:
    made: AbstractDisturbance = TypeAdapter(Disturbance).validate_python({"at": "motor_1", **settings})
    return made


def signal(n: int, *disturbances: AbstractDisturbance, first: int = 0, seed: int = 1) -> FloatArray:
    return disturbance_signal(disturbances, 1, T, seed).rows(first, n)


def test_step_begins_at_its_sample_despite_rounding() -> None:
    values = signal(700, make(kind="step", amplitude=3.0, start=0.3))[:, 0]  # 0.3 / 0.0005 is 599.99...
    assert np.flatnonzero(values)[0] == 600
    assert set(values[600:]) == {3.0}


def test_start_between_samples_waits_for_the_next_one() -> None:
    values = signal(10, make(kind="step", amplitude=1.0, start=2.4 * T))[:, 0]
    assert np.flatnonzero(values)[0] == 3


def test_pulse_lasts_its_width() -> None:
    values = signal(100, make(kind="pulse", amplitude=-2.0, start=0.01, width=0.005))[:, 0]
    assert np.flatnonzero(values).tolist() == list(range(20, 30))
    assert set(values[20:30]) == {-2.0}


def test_chirp_sweeps_between_its_frequencies() -> None:
    values = signal(8000, make(kind="chirp", amplitude=2.0, from_hz=5.0, to_hz=50.0, duration=3.0, start=0.5))[:, 0]
    assert not np.any(values[:1000])
    assert not np.any(values[7000:])
    crossings = 1000 + np.flatnonzero(np.diff(np.signbit(values[1000:7000])))
    np.testing.assert_allclose(len(crossings), 2 * 3.0 * (5 + 50) / 2, atol=1.01)  # two for each turn
    np.testing.assert_allclose(1 / (2 * T * np.diff(crossings)[-5:]), 50.0, rtol=0.06)


def test_noise_has_its_rms_and_stays_in_its_band() -> None:
    values = signal(40_000, make(kind="noise", rms=0.7, low_hz=20.0, high_hz=60.0, period=20.0))[:, 0]
    np.testing.assert_allclose(np.sqrt(np.mean(values**2)), 0.7, rtol=1e-12)
    spectrum = np.abs(np.fft.rfft(values)) ** 2
    inside = slice(20 * 20, 60 * 20 + 1)
    assert np.sum(spectrum) - np.sum(spectrum[inside]) < 1e-20 * np.sum(spectrum)
    assert np.mean(values**4) / np.mean(values**2) ** 2 == pytest.approx(3.0, abs=0.15)  # that of normal noise


def test_noise_depends_on_seed_and_index_in_the_list() -> None:
    noise = make(kind="noise", rms=1.0, high_hz=60.0)
    other = noise.model_copy(update={"at": "tool.fx"})
    both = signal(100, noise, other)
    assert not np.array_equal(both[:, 0], both[:, 1])
    assert not np.array_equal(both[:, 0], signal(100, noise, seed=2)[:, 0])


def test_locations_are_columns_and_add_up() -> None:
    values = signal(
        2,
        make(kind="step", amplitude=1.0),
        make(kind="step", amplitude=2.0),
        make(kind="step", amplitude=5.0, at="tool.tz"),
    )
    assert values.tolist() == [[3.0, 0, 0, 0, 0, 0, 5.0]] * 2


@pytest.mark.parametrize("kind", ["step", "pulse", "chirp", "noise"])
def test_values_do_not_depend_on_slicing(kind: str) -> None:
    settings = {
        "step": {"amplitude": 1.0, "start": 0.77},
        "pulse": {"amplitude": 1.0, "start": 0.5, "width": 0.3},
        "chirp": {"amplitude": 1.0, "from_hz": 3.0, "to_hz": 60.0, "duration": 1.2},
        "noise": {"rms": 1.0, "high_hz": 100.0, "period": 0.7},
    }
    disturbance = make(kind=kind, **settings[kind])
    one_by_one = np.vstack([signal(1, disturbance, first=k) for k in range(1000, 1060)])
    assert np.array_equal(one_by_one, signal(60, disturbance, first=1000))


def test_unknown_location_is_named_with_the_allowed_ones() -> None:
    with pytest.raises(
        InputError, match=r"unknown location 'motor_2' in disturbances\[0\]\.at: did you mean 'motor_1'\?"
    ):
        signal(1, make(kind="step", amplitude=1.0, at="motor_2"))


def test_frequency_above_half_the_sampling_rate_is_refused() -> None:
    with pytest.raises(InputError, match=r"disturbances\[0\] reaches 1200 Hz, .* half the sampling rate, 1000 Hz"):
        signal(1, make(kind="chirp", amplitude=1.0, from_hz=1.0, to_hz=1200.0, duration=1.0))


def test_empty_band_is_refused() -> None:
    with pytest.raises(InputError, match=r"holds no line of the period of 0\.5 s .* widen it or lengthen the period"):
        signal(1, make(kind="noise", rms=1.0, low_hz=10.1, high_hz=11.0, period=0.5))


def test_band_is_checked_with_the_period_in_whole_samples() -> None:
    noise = make(kind="noise", rms=1.0, low_hz=1.0001, high_hz=1.0004, period=0.9998)  # its line is at 1.0002 Hz
    assert np.all(np.isfinite(disturbance_signal((noise,), 1, 1e-4, 1).rows(0, 100)))
    with pytest.raises(
        InputError,
        match=r"^disturbances\[0\]: the band from 1\.0001 to 1\.0004 Hz holds no line of the period of 1 s \(2000 "
        r"samples\), allowed is a band with a multiple of 1 Hz; widen it or lengthen the period$",
    ):
        signal(1, noise)


def test_band_upside_down_is_refused() -> None:
    with pytest.raises(ValidationError, match="high_hz is 5 Hz, but must be above low_hz = 9 Hz"):
        make(kind="noise", rms=1.0, low_hz=9.0, high_hz=5.0)
