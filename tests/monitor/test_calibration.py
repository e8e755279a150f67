"""Calibrations: tails that are known, short logs, files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.monitor.calibration import LEAST_FALL, Calibration, Tail, calibrate, read_calibration, write_calibration

NAMES = ("motor_1",)


def of(values: np.ndarray) -> Calibration:
    return calibrate(values, np.zeros((len(values), 3)), NAMES, model="abc", robot="one", log="log")


def test_a_tail_is_read_off_and_taken_a_little_slower() -> None:
    """Logarithms that fall off exponentially: the level of a probability is known, and the estimate is above it."""
    rng = np.random.default_rng(1)
    known = of(np.exp(rng.exponential(0.3, size=(20_000, 2))))
    tail = known.tails["motor_1.sudden"][0]
    assert tail is not None
    assert 0.3 < tail.fall < 0.33
    assert tail.level(1e-6) == pytest.approx(np.exp(0.3 * np.log(1e6)), rel=0.5)
    assert tail.level(1e-6) > np.exp(0.3 * np.log(1e6))


def test_levels_of_lengths_that_the_log_is_too_short_for_are_infinite() -> None:
    known = of(np.random.default_rng(2).uniform(1, 2, size=(60, 2)))
    levels = known.levels(np.full(3, 1e-6))
    assert np.all(np.isfinite(levels[:2]))
    assert np.all(np.isinf(levels[2]))


def test_a_signal_that_is_constant_has_the_least_tail() -> None:
    known = of(np.full((600, 2), 7.0))
    np.testing.assert_allclose(known.levels(np.full(3, 1e-9)), 7.0 * np.exp(LEAST_FALL * np.log(0.2 / 1e-9)), rtol=1e-6)
    assert known.accepted == {"motor_1": pytest.approx(np.sqrt(7.0))}


def test_a_log_that_is_too_short_is_refused() -> None:
    with pytest.raises(InputError, match=r"^log: 4.9 s of it could be monitored, at least 5 s are needed"):
        of(np.ones((49, 2)))


def test_a_file_gives_the_calibration_again(tmp_path: Path) -> None:
    known = of(np.random.default_rng(3).uniform(1, 2, size=(60, 2)))
    write_calibration(tmp_path / "accepted.json", known)
    assert read_calibration(tmp_path / "accepted.json", "abc", NAMES) == known


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (
            None,
            r"the calibration .*f.json cannot be read .*; calibrate",
        ),
        ("[1]", "is no JSON object; calibrate"),
        ("{", "cannot be read"),
        ('{"model": 1}', "f.json"),
    ],
)
def test_files_that_are_none_are_refused(tmp_path: Path, content: str | None, told: str) -> None:
    if content is not None:
        (tmp_path / "f.json").write_text(content)
    with pytest.raises(InputError, match=told):
        read_calibration(tmp_path / "f.json", "abc", NAMES)


@pytest.mark.parametrize(("model", "names"), [("other", NAMES), ("abc", ("motor_1", "motor_2"))])
def test_a_calibration_of_another_model_is_refused(tmp_path: Path, model: str, names: tuple[str, ...]) -> None:
    write_calibration(tmp_path / "f.json", of(np.ones((60, 2))))
    with pytest.raises(InputError, match="was made for robot one with fingerprint abc, but the model has .* calibrate"):
        read_calibration(tmp_path / "f.json", model, names)


def test_what_is_accepted_grows_with_what_the_robot_does() -> None:
    """Mean squares that are noise plus a share of the squared acceleration: the share is found, the rest is narrow."""
    rng = np.random.default_rng(5)
    motion = rng.exponential(1.0, size=(2000, 3)) ** 3
    values = (1 + motion[:, [2, 2]] * [4.0, 900.0]) * np.exp(0.1 * rng.normal(size=(2000, 2)))
    known = calibrate(values, motion, NAMES, model="abc", robot="one", log="log")
    np.testing.assert_allclose(known.expected(np.array([0.0, 0.0, 2.0])), [9.0, 1801.0], rtol=0.1)
    tail = known.tails["motor_1.torque"][0]
    assert tail is not None
    assert tail.level(1e-9) < 70.0


def test_levels_stay_finite() -> None:
    assert np.isfinite(Tail(begins=100.0, fall=1e6, share=0.2).level(1e-12))
