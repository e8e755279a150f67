"""Quantization step of a signal."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.quantization import encoder_quantization, lattice_step
from flexros.record.record import Record
from flexros.robot import load_robot

N = 4000


def motion(seed: int, noise: float = 1e-4, n: int = N) -> np.ndarray:
    """Random slow motion of some radians with noise in every sample."""
    rng = np.random.default_rng(seed)
    time = np.arange(n) * 5e-4
    size, rate, phase = rng.uniform(0.01, 3, 4), rng.uniform(0.1, 5, 4), rng.uniform(0, 6, 4)
    return np.sin(2 * np.pi * np.outer(time, rate) + phase) @ size + noise * rng.normal(size=n)


def test_no_false_alarm_in_100_logs_with_noise() -> None:
    assert [seed for seed in range(100) if lattice_step(motion(seed, noise=10.0 ** -(2 + seed % 5))) is not None] == []


@pytest.mark.parametrize("over_noise", [0.5, 1.0, 3.0, 10.0, 100.0])
@pytest.mark.parametrize("ratio", [1.0, 121.7])
def test_step_is_found(over_noise: float, ratio: float) -> None:
    step = over_noise * 1e-4
    for seed in range(5):
        seen = step * np.floor(motion(seed) / step) / ratio
        assert lattice_step(seen) == pytest.approx(step / ratio, rel=1e-6)


def test_offset_of_the_lattice_does_not_matter() -> None:
    assert lattice_step(1e-3 * np.round(motion(3) / 1e-3) + 0.123456) == pytest.approx(1e-3, rel=1e-6)


def test_constant_and_binary_signals_have_no_lattice() -> None:
    assert lattice_step(np.full(N, 1.0)) is None
    assert lattice_step(np.sign(motion(1))) is None


def test_decimals_of_a_text_file_are_a_lattice() -> None:
    assert lattice_step(np.round(motion(1), 5)) == pytest.approx(1e-5, rel=1e-6)


@pytest.mark.parametrize("digits", [7, 8])
def test_text_of_eight_digits_has_one_decimal_less_from_1_on(digits: int) -> None:
    """At turning points and at rest small differences are then those of the text, not steps of the encoder."""
    turning = 1.0 + 0.3 * np.sin(2 * np.pi * 0.2 * np.arange(N) * 4e-3) + 2e-6 * np.random.default_rng(0).normal(size=N)
    step = 2 * np.pi / 2**17
    text = [f"{value:.{digits}g}" for value in step * np.round(turning / step)]
    assert lattice_step(np.array(text, dtype=float)) == pytest.approx(step, rel=1e-4)


def record(position: np.ndarray) -> Record:
    return Record("log", 5e-4, position[:, None], np.zeros((len(position), 1)), np.ones(len(position), dtype=bool))


@pytest.mark.parametrize(("step", "coarse"), [(3e-4, False), (1e-3, True)])
def test_step_well_above_the_noise_is_coarse(step: float, coarse: bool) -> None:
    robot = load_robot("four_mass_linear")  # noise 1e-4 rad
    (found,) = encoder_quantization(record(step * np.round(motion(1) / step)), robot, 6.0)
    assert found.motor == 0
    assert found.step == pytest.approx(step, rel=1e-6)
    assert found.coarse is coarse


def test_step_far_below_the_noise_is_no_effect() -> None:
    robot = load_robot("four_mass_linear")
    assert encoder_quantization(record(np.round(motion(1), 6)), robot, 6.0) == ()
    assert encoder_quantization(record(motion(1)), robot, 6.0) == ()


def test_step_is_found_in_a_file_of_rounded_decimals() -> None:
    time = np.arange(5000) * 2e-3
    true = 3.0679615758e-5 * np.round(0.4 * np.sin(2 * np.pi * 0.7 * time) / 3.0679615758e-5)
    written = np.array([float(f"{value:.9g}") for value in np.rad2deg(true)])
    assert lattice_step(np.deg2rad(written)) == pytest.approx(3.068e-5, rel=1e-3)
