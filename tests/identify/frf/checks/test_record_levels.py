"""Excitation, periods, saturation and aliasing of records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.checks.record_levels import (
    check_aliasing,
    check_certainty,
    check_periods,
    check_reference,
    check_saturation,
)
from flexros.identify.frf.estimate.periodic import periodic_response, spectra_of
from flexros.identify.frf.experiments import Experiments
from flexros.identify.frf.settings import FrfSettings

N, T = 400, 1e-3
LINES = np.arange(1, 40, 2)


def record(noise: float = 0.01, n_periods: int = 3, size: float = 1.0, lines: np.ndarray = LINES) -> Experiments:
    """Two experiments of one motor whose response is 2."""
    rng = np.random.default_rng(0)
    t = np.arange(n_periods * N)
    u = np.array([np.cos(2 * np.pi * np.outer(t, lines) / N + rng.uniform(0, 6, len(lines))).sum(axis=1) for _ in "ab"])
    u = size * u + noise * rng.standard_normal(u.shape)
    y = 2 * u + noise * rng.standard_normal(u.shape)
    return Experiments.of(u, y, T, n_periods=n_periods, lines=lines, label="position 1")


def check(mine: Experiments) -> None:
    check_periods(mine, spectra_of(mine, FrfSettings()))


@pytest.mark.parametrize("n_periods", [1, 2, 3])
def test_excited_record_passes(n_periods: int) -> None:
    check(record(n_periods=n_periods))


@pytest.mark.parametrize("n_periods", [1, 2, 3])
def test_record_without_excitation_is_refused(n_periods: int) -> None:
    with pytest.raises(
        InputError, match="position 1: no excitation: the torque of motor_1 at the excited lines is not"
    ):
        check(record(n_periods=n_periods, size=0.0))


def test_record_without_any_torque_is_refused() -> None:
    with pytest.raises(InputError, match="no excitation"):
        check(record(noise=0.0, size=0.0))


@pytest.mark.parametrize("n_periods", [2, 3])
def test_missing_period_is_named(n_periods: int) -> None:
    mine = record(n_periods=n_periods)
    u = mine.inputs.copy()
    u[1, N : 2 * N] *= 0.01
    with pytest.raises(
        InputError, match="position 1: period 2 of experiment 2 is missing: it has 0.0. of the excitation"
    ):
        check(replace(mine, inputs=u))


@pytest.mark.parametrize("n_periods", [1, 2, 3])
def test_experiment_without_command_is_named(n_periods: int) -> None:
    mine = record(n_periods=n_periods)
    u = mine.inputs.copy()
    u[1] = 7.3
    with pytest.raises(InputError, match="position 1: no excitation: the torque of experiment 2 of 2 is zero at all"):
        check(replace(mine, inputs=u))


def test_experiment_without_command_does_not_hide_a_missing_period() -> None:
    mine = record()
    spectra = spectra_of(mine, FrfSettings())
    spectra.input[0], spectra.input[1, 2] = 0.0, 0.0
    with pytest.raises(InputError, match="no excitation: the torque of experiment 1 of 2 is zero"):
        check_periods(mine, spectra)
    spectra.input[0] = spectra.input[1, 0]
    with pytest.raises(InputError, match="position 1: period 3 of experiment 2 is missing"):
        check_periods(mine, spectra)


def test_experiment_of_noise_alone_is_named() -> None:
    mine = record()
    spectra = spectra_of(mine, FrfSettings())
    real, imaginary = np.random.default_rng(3).standard_normal((2, *spectra.input[1].shape))
    spectra.input[1] = 1e-3 * (real + 1j * imaginary)
    with pytest.raises(InputError, match="no excitation: in experiment 2 of 2 no torque at the excited lines is above"):
        check_periods(mine, spectra)


def test_reference_at_rest_is_no_excitation() -> None:
    mine = record()
    with pytest.raises(InputError, match="no excitation: the reference of motor_1 does not move"):
        check_reference(replace(mine, reference=np.ones(mine.inputs.shape)))
    assert check_reference(replace(mine, reference=mine.inputs)) == []
    assert "the reference is not known" in check_reference(mine)[0]


def test_torque_at_its_limit_is_refused_or_warned_of() -> None:
    mine = record()
    largest = np.max(abs(mine.inputs))
    assert check_saturation(mine, np.array([2 * largest])) == []
    clipped = replace(mine, inputs=np.clip(mine.inputs, -0.4 * largest, 0.4 * largest))
    with pytest.raises(InputError, match="position 1: saturated torque: the command of motor_1 is at its limit of"):
        check_saturation(clipped, np.array([0.4 * largest]))
    little = replace(mine, inputs=np.clip(mine.inputs, -0.97 * largest, 0.97 * largest))
    assert "saturated torque: the command of motor_1 is at" in check_saturation(little, np.array([0.97 * largest]))[0]


def test_plateaus_are_taken_for_a_limit_that_is_not_known() -> None:
    mine = record()
    largest = np.max(abs(mine.inputs))
    assert check_saturation(mine, None) == []
    with pytest.raises(InputError, match="saturated torque"):
        check_saturation(replace(mine, inputs=np.clip(mine.inputs, -0.4 * largest, 0.4 * largest)), None)


def test_plateau_is_as_long_as_the_constant_says(monkeypatch: pytest.MonkeyPatch) -> None:
    mine = record()
    place = int(np.argmax(mine.inputs[0, :, 0]))
    u = mine.inputs.copy()
    u[0, place : place + 4] = u.max()
    flat = replace(mine, inputs=u)
    assert "saturated torque" in check_saturation(flat, None)[0]
    monkeypatch.setattr("flexros.identify.frf.checks.record_levels.LONGEST_PLATEAU", 5)
    assert check_saturation(flat, None) == []


def test_command_beyond_the_limit_did_not_act() -> None:
    with pytest.raises(InputError, match="saturated torque: motor_1 was commanded .*, beyond its limit of 1, so the"):
        check_saturation(record(), np.array([1.0]))


def test_lines_near_the_nyquist_frequency_are_warned_of() -> None:
    assert check_aliasing(record()) == []
    assert "aliasing: lines up to 447.5 Hz are excited" in check_aliasing(record(lines=np.array([1, 179])))[0]


def test_folded_energy_is_warned_of() -> None:
    mine = record()
    folded = mine.inputs + 2.0 * np.cos(2 * np.pi * 210 * np.arange(3 * N)[:, None] / N)
    assert "aliasing: the torque of motor_1 has" in check_aliasing(replace(mine, inputs=folded))[0]
    noisy = mine.inputs + 2.0 * np.random.default_rng(1).standard_normal(mine.inputs.shape)
    assert check_aliasing(replace(mine, inputs=noisy)) == []


def test_response_below_its_deviation_is_refused_and_a_weak_one_warned_of() -> None:
    good = periodic_response(record(), FrfSettings())
    assert check_certainty(good, "position 1") == []
    assert good.total_error is not None
    size = abs(good.response[:, 0, 0]) / good.standard_deviation()[:, 0, 0]
    weak = replace(good, total_error=good.total_error * (0.7 * size[:, None, None]) ** 2)
    assert f"at {len(LINES)} of {len(LINES)} lines a diagonal entry is less than 6 dB" in check_certainty(weak, "p")[0]
    poor = replace(good, total_error=good.total_error * (2 * size[:, None, None]) ** 2)
    with pytest.raises(InputError, match="position 1: no excitation: the response of motor_1 to itself is below its"):
        check_certainty(poor, "position 1")
