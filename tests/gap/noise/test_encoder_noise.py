"""Noise of the encoders as a log shows it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.noise import encoder_noise
from flexros.gap.noise.encoder_noise import measure_noise
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from flexros.robot import Robot, load_robot

pytestmark = pytest.mark.slow

N, T, SIGMA = 40_000, 5e-4, 1e-4

SETTINGS = DiagnosisSettings()


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("four_mass_linear")  # its file says SIGMA


def record_of(noise: np.ndarray, still: bool, jitter: float = 0.0, imported: bool = False, seed: int = 3) -> Record:
    """Slow swings, standing still in the first quarter where asked for."""
    time = np.arange(N) * T
    seen = time + jitter * np.random.default_rng(seed).normal(size=N)
    moving = np.where(time < 5.0, 0.0, 1.0) if still else np.ones(N)
    motion = moving * 2.0 * (1 - np.cos(2 * np.pi * 0.4 * (seen - 5.0)))
    return Record(
        name="log",
        sample_time=T,
        position=(motion + noise)[:, None],
        torque=np.zeros((N, 1)),
        valid=np.ones(N, dtype=bool),
        imported=imported,
    )


def white(scale: float = SIGMA, seed: int = 1) -> np.ndarray:
    return scale * np.random.default_rng(seed).normal(size=N)


def coloured(a: float, seed: int = 1) -> np.ndarray:
    """Noise e_k = a e_(k-1) + w_k of size SIGMA."""
    from scipy.signal import lfilter

    return lfilter([np.sqrt(1 - a**2)], [1.0, -a], white(seed=seed))


@pytest.mark.parametrize(("still", "source"), [(True, "standstill"), (False, "above the band")])
def test_white_noise_is_measured_with_and_without_standstill(robot: Robot, still: bool, source: str) -> None:
    for seed in range(5):
        noise = measure_noise(record_of(white(1.1 * SIGMA, seed), still), robot, SETTINGS)
        assert noise.source == (source,)
        assert noise.standard_deviation[0] == pytest.approx(1.1 * SIGMA, rel=0.05)
        assert noise.autoregression.shape == (1, 0)
        assert noise.jitter == 0.0
        assert noise.warnings == ()


def test_a_little_less_at_standstill_is_chance_where_the_band_above_shows_the_stated_noise(robot: Robot) -> None:
    values = white()
    values[: N // 4] *= 0.92
    noise = measure_noise(record_of(values, still=True), robot, SETTINGS)
    assert noise.source == ("above the band",)
    assert noise.standard_deviation[0] == pytest.approx(SIGMA, rel=0.05)


def test_noise_unlike_the_robot_file_is_reported(robot: Robot) -> None:
    noise = measure_noise(record_of(white(2 * SIGMA), still=True), robot, SETTINGS)
    assert noise.standard_deviation[0] == pytest.approx(2 * SIGMA, rel=0.05)
    (warning,) = noise.warnings
    assert f"encoder noise of motor_1 is {noise.standard_deviation[0]:.3g} (standstill)" in warning
    assert "declares 0.0001" in warning


def test_noise_unlike_the_robot_file_at_several_motors_is_reported_once() -> None:
    """Six lines said the same of an arm of six axes."""
    robot = load_robot("elbow")
    stated = robot.encoder_noise
    warnings = encoder_noise._warnings(
        0.5 * stated, [np.zeros(0)] * len(stated), 0.0, ["above the band"] * len(stated), robot, SETTINGS.noise
    )
    (warning,) = warnings
    assert warning.startswith(f"the encoder noise of {', '.join(robot.joint_names)} is ")
    assert warning.endswith(
        "(above the band), the robot file declares " + f"{stated[0]:.3g}; the measured values are used"
    )


@pytest.mark.parametrize("a", [0.3, 0.8, -0.4])
def test_colour_is_found(robot: Robot, a: float) -> None:
    noise = measure_noise(record_of(coloured(a), still=True), robot, SETTINGS)
    assert noise.autoregression[0, 0] == pytest.approx(a, abs=0.05)
    assert noise.standard_deviation[0] == pytest.approx(SIGMA, rel=0.1)
    assert any("is not white (autoregression" in text for text in noise.warnings)


@pytest.mark.parametrize(("step", "shows"), [(0.3, True), (1.0, True), (3.0, False)])
def test_rounding_below_the_noise_does_not_hide_its_colour(robot: Robot, step: float, shows: bool) -> None:
    """A fine step adds a little white noise; a coarse one hides the noise, and that of the robot file counts."""
    record = record_of(coloured(0.8), still=True)
    rounded = replace(record, position=step * SIGMA * np.round(record.position / (step * SIGMA)))
    noise = measure_noise(rounded, robot, SETTINGS)
    assert noise.source == ("standstill" if shows else "robot file",)
    if shows:
        assert noise.autoregression[0].sum() == pytest.approx(0.8, abs=0.1)
        assert noise.standard_deviation[0] == pytest.approx(np.hypot(1, step / np.sqrt(12)) * SIGMA, rel=0.1)
    else:
        assert noise.autoregression.shape == (1, 0)


def test_jitter_of_the_clock_shows_between_pauses(robot: Robot) -> None:
    """An arm that picks and places rests for half of the time, and beside its rest all motion was an outlier."""
    phase = (np.arange(N) * T + 1e-4 * np.random.default_rng(3).normal(size=N)) % 4.0
    motion = np.where(phase < 2.2, 1 - np.cos(2 * np.pi * phase / 2.2), 0.0)
    record = replace(record_of(white(), still=False), position=(motion + white(1e-3 * SIGMA))[:, None])
    assert measure_noise(record, robot, SETTINGS).jitter == pytest.approx(1e-4, rel=0.1)


@pytest.mark.parametrize("still", [True, False])
def test_jitter_of_the_clock_grows_with_speed(robot: Robot, still: bool) -> None:
    noise = measure_noise(record_of(white(), still, jitter=3e-5), robot, SETTINGS)
    assert noise.jitter == pytest.approx(3e-5, rel=0.15)
    assert noise.standard_deviation[0] == pytest.approx(SIGMA, rel=0.1)
    assert any("grows with speed" in text and "us rms" in text for text in noise.warnings)


def test_only_logs_of_real_machines_get_a_signal_tolerance(robot: Robot) -> None:
    simulated, real = (
        measure_noise(record_of(white(), still=True, imported=imported), robot, SETTINGS) for imported in (False, True)
    )
    assert simulated.signal_tolerance == 0.0
    assert real.signal_tolerance == SETTINGS.noise.signal_tolerance


def test_log_without_noise_takes_that_of_the_robot_file(robot: Robot) -> None:
    record = record_of(np.zeros(N), still=True)
    constant = Record("log", T, np.zeros((N, 1)), record.torque, record.valid)
    noise = measure_noise(constant, robot, SETTINGS)
    assert noise.source == ("robot file",)
    assert noise.standard_deviation[0] == robot.encoder_noise[0]


def test_implausibly_quiet_positions_of_a_real_machine_get_the_noise_of_the_robot_file(robot: Robot) -> None:
    noise = measure_noise(record_of(white(0.1 * SIGMA), still=True, imported=True), robot, SETTINGS)
    assert noise.standard_deviation[0] == robot.encoder_noise[0]
    assert noise.source == ("robot file",)
    assert len(noise.warnings) == 1
    assert "the 0.0001 of the robot file is used" in noise.warnings[0]
    simulated = measure_noise(record_of(white(0.1 * SIGMA), still=True), robot, SETTINGS)
    assert simulated.standard_deviation[0] == pytest.approx(0.1 * SIGMA, rel=0.1)


def test_a_small_swing_at_rest_is_no_colour_where_the_band_above_shows_the_stated_noise(robot: Robot) -> None:
    time = np.arange(N) * T
    swing = 4e-4 * np.sin(2 * np.pi * 5.0 * time)
    position = (swing + SIGMA * np.random.default_rng(7).normal(size=N))[:, None]
    noise = measure_noise(Record("log", T, position, np.zeros_like(position), np.ones(N, bool)), robot, SETTINGS)
    assert noise.standard_deviation[0] == pytest.approx(SIGMA, rel=0.03)
    assert not noise.autoregression.size


def test_rounding_of_numbers_is_no_jitter(robot: Robot) -> None:
    """Faster and faster at constant speeds: what is left of exact positions grows with them, 1e-16 of their size."""
    record = record_of(np.zeros(N), still=False, imported=True)
    faster = np.cumsum(np.repeat(np.linspace(0.2, 8.0, 20), N // 20)) * T
    noise = measure_noise(replace(record, position=faster[:, None]), robot, SETTINGS)
    assert noise.jitter == 0.0
    assert not any("grows with speed" in text for text in noise.warnings)


@pytest.mark.parametrize("step", [5e-5, 1e-4, 5e-4, 1e-3, 5e-3])  # up to 50 and 0.5 steps per sample
def test_rounding_of_a_coarse_encoder_is_no_jitter(robot: Robot, step: float) -> None:
    record = record_of(white(0.1 * SIGMA), still=True)
    record = replace(record, position=step * np.round(record.position / step))
    assert measure_noise(record, robot, SETTINGS).jitter == 0.0


def test_jitter_is_found_beside_rounding_at_high_speed(robot: Robot) -> None:
    record = record_of(white(0.1 * SIGMA), still=True, jitter=1e-4)
    record = replace(record, position=3e-4 * np.round(record.position / 3e-4))
    assert measure_noise(record, robot, SETTINGS).jitter == pytest.approx(1e-4, rel=0.1)


def test_positions_that_never_change_have_no_noise(robot: Robot) -> None:
    """Numerical errors of a filter are none; the robot file states what the encoder has."""
    record = record_of(white(), still=True)
    noise = measure_noise(replace(record, position=np.full((N, 1), 0.1654815673828125)), robot, SETTINGS)
    assert (noise.source, noise.warnings) == (("robot file",), ())
    np.testing.assert_array_equal(noise.standard_deviation, robot.encoder_noise)


def test_the_colour_of_a_motor_that_is_not_predicted_does_not_count(robot: Robot) -> None:
    record = replace(record_of(coloured(0.8), still=True), prescribed=(0,))
    noise = measure_noise(record, robot, SETTINGS)
    assert noise.autoregression.shape == (1, 0)
    assert not any("is not white" in text for text in noise.warnings)
