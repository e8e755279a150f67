"""Chirp and burst: records from rest to rest."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from flexros.errors import InputError
from flexros.identify.excitation.base import AbstractExcitation
from flexros.identify.excitation.burst import Burst
from flexros.identify.excitation.chirp import Chirp

T = 1e-3
EXCITATIONS = [
    Chirp(kind="chirp", duration=4.0, from_hz=50.0, to_hz=1.0),
    Chirp(kind="chirp", duration=4.0, from_hz=1.0, to_hz=50.0, sweep="logarithmic"),
    Burst(kind="burst"),
    Burst(kind="burst", content="multisine", orthogonal=False),
]


@pytest.mark.parametrize("excitation", EXCITATIONS, ids=lambda e: f"{e.kind}")
def test_record_begins_and_ends_at_rest_in_its_place(excitation: AbstractExcitation) -> None:
    signals = excitation.block(2, T, 1, 0, 0)
    rest = round(excitation.rest_after / T)  # type: ignore[attr-defined]
    assert np.all(signals.speed[:, -rest:] == 0.0)
    assert np.all(signals.position[:, -rest:] == 0.0)
    assert np.all(signals.position[:, 0] == 0.0)
    assert np.max(np.abs(signals.speed)) > 0.01


@pytest.mark.parametrize("excitation", EXCITATIONS, ids=lambda e: f"{e.kind}")
def test_speed_is_the_derivative_of_the_position(excitation: AbstractExcitation) -> None:
    fine = 1e-4
    signals = excitation.block(1, fine, 1, 0, 0)
    x, v = signals.position[0, :, 0], signals.speed[0, :, 0]
    moved = fine / 3.0 * (v[:-2] + 4.0 * v[1:-1] + v[2:])  # Simpson's rule, error of order fine^5
    np.testing.assert_allclose(x[2:] - x[:-2], moved, atol=1e-9)


def test_chirp_sweeps_from_high_to_low() -> None:
    chirp = EXCITATIONS[0]
    speed = chirp.block(1, T, 1, 0, 0).speed[0, 500:4500, 0]
    crossings = np.flatnonzero(np.diff(np.sign(speed)) != 0)
    begin, end = (np.sum((crossings >= first) & (crossings < first + 500)) for first in (500, 3400))
    assert begin == pytest.approx(2 * 0.5 * 40.8, abs=2)  # mean frequency of the half second from 0.5 s on
    assert end == pytest.approx(2 * 0.5 * 5.3, abs=2)


def test_chirp_has_the_amplitude_asked_for() -> None:
    speed = Chirp(kind="chirp", amplitude=0.5).block(1, T, 1, 0, 0).speed
    assert np.max(np.abs(speed)) == pytest.approx(0.5, rel=0.03)


@pytest.mark.parametrize("excitation", EXCITATIONS[:3], ids=lambda e: f"{e.kind}")
def test_motors_of_an_orthogonal_set_are_orthogonal_inside_the_band(excitation: AbstractExcitation) -> None:
    U = np.fft.rfft(excitation.block(3, T, 1, 0, 0).speed, axis=1).transpose(1, 2, 0)
    U = U[excitation.lines(T, 1).excited[10:-10]]
    U /= np.linalg.norm(U, axis=2, keepdims=True)
    gram = np.abs(U @ U.conj().swapaxes(1, 2) - np.eye(3))
    assert np.median(gram) < 1e-3


def test_lines_are_all_those_of_the_band() -> None:
    lines = Burst(kind="burst", rest_before=0.0, duration=4.0, rest_after=1.0, lowest=1.0, highest=3.0).lines(T, 1)
    assert np.array_equal(lines.excited, np.arange(5, 16))
    assert lines.odd_detection.size == 0


def test_burst_of_noise_is_new_in_every_block_and_normal_in_size() -> None:
    burst = Burst(kind="burst", duration=30.0, amplitude=0.1)
    one, two = (burst.block(1, T, 1, 0, block).speed[0, 500:29000, 0] for block in (0, 1))
    assert np.std(one) == pytest.approx(0.1, rel=0.1)
    assert abs(np.corrcoef(one, two)[0, 1]) < 0.2
    assert np.mean(one**4) / np.mean(one**2) ** 2 == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("kind", [Chirp, Burst])
def test_every_part_of_a_record_is_whole_samples(kind: type[Chirp | Burst]) -> None:
    name = kind.__name__.lower()
    with pytest.raises(
        InputError, match=r"excitation\.rest_before is 0\.00075 s, allowed is a whole number of samples of 0\.0005 s, 0"
    ):
        kind(kind=name, rest_before=0.00075, duration=0.10075, rest_after=0.0, taper=0.02).block(1, 5e-4, 1, 0, 0)
    with pytest.raises(InputError, match=r"excitation\.duration is 1\.0002 s, .* 2 or more; set it e\.g\. to 1$"):
        kind(kind=name, duration=1.0002).record_samples(5e-4)
    with pytest.raises(InputError, match=r"excitation\.rest_after is 0\.0003 s, .* 0 or more; set it e\.g\. to 0$"):
        kind(kind=name, rest_after=0.0003).record_samples(5e-4)


@pytest.mark.parametrize("kind", [Chirp, Burst])
@pytest.mark.parametrize(("duration", "taper"), [(0.203, 0.1015), (0.2, 1e-6), (0.2, 0.0303)])
def test_taper_is_rounded_to_samples_that_fit(kind: type[Chirp | Burst], duration: float, taper: float) -> None:
    excitation = kind(kind=kind.__name__.lower(), rest_before=0.0, duration=duration, rest_after=0.001, taper=taper)
    signals = excitation.block(1, T, 1, 0, 0)
    assert signals.speed.shape == (1, excitation.record_samples(T), 1)
    assert np.all(np.isfinite(signals.speed))
    assert np.all(signals.position[0, [0, -1]] == 0.0)


def test_frequencies_and_times_are_checked() -> None:
    with pytest.raises(InputError, match=r"excitation\.from_hz is 600 Hz, allowed is less than half .* 500 Hz"):
        Chirp(kind="chirp", from_hz=600.0).lines(T, 1)
    with pytest.raises(InputError, match=r"excitation\.highest is 500 Hz"):
        Burst(kind="burst", highest=500.0).record_samples(T)
    for kind in (Chirp, Burst):
        with pytest.raises(ValidationError, match="taper is 3 s, allowed is at most half the duration of 4 s"):
            kind(kind=kind.__name__.lower(), duration=4.0, taper=3.0)
