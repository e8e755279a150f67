"""Linear and nonlinear gaps at the lines of a multisine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.gap.noise.autoregression import white_spectrum
from flexros.gap.settings import WhereSettings
from flexros.gap.signatures.detection_lines import DetectionLines as DetectionLinePicture
from flexros.gap.signatures.signature_data import SignatureData
from flexros.gap.where.base import Location
from flexros.gap.where.find import where
from flexros.gap.where.prediction_errors import PredictionErrors
from flexros.gap.where.views.detection_lines import DetectionLines, line_levels
from flexros.record.periodic_parts import PeriodicPart, periodic_parts
from flexros.robot import load_robot
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.oracles.linear_gap import LinearLog, Torque, linear_log, nothing

pytestmark = pytest.mark.slow

PERIOD = 4000
LINES = np.array([line for line in range(1, 121, 2) if line % 8 != 5])
PART = PeriodicPart(first=PERIOD, period=PERIOD, n_periods=3, lines=LINES)


def shaken(missing: Torque) -> LinearLog:
    robot = load_robot("four_mass_linear")
    phase = np.random.default_rng(3).uniform(0, 2 * np.pi, len(LINES))
    time = np.arange(4 * PERIOD) / PERIOD
    reference = 0.1 * np.cos(2 * np.pi * np.outer(time, LINES) + phase).sum(axis=1)[:, None]
    return linear_log(robot, reference, (10.0, 0.8), missing)


def locations(log: LinearLog) -> Sequence[Location]:
    record = replace(log.record, parts=(PART,))
    return DetectionLines.of_log(
        PredictionErrors(log.prediction, record, log.robot, white_spectrum(1), None, WhereSettings())
    )


def significant(log: LinearLog) -> set[str]:
    return {location.signal for location in locations(log) if location.p_value < 0.01}


def linear(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
    del time, position, speed
    return np.asarray(-0.1 * command)


def cubic(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
    del time, speed, command
    return np.asarray(-0.3 * position**3)


def square(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
    del time, speed, command
    return np.asarray(-0.3 * position**2)


@pytest.mark.parametrize(
    ("missing", "lines"),
    [
        (nothing, set()),
        (linear, {"excited lines"}),
        (cubic, {"excited lines", "odd detection lines"}),
        (square, {"even detection lines"}),
    ],
)
def test_lines_separate_linear_from_nonlinear(missing: Torque, lines: set[str]) -> None:
    assert significant(shaken(missing)) == lines


def test_distance_is_one_for_noise() -> None:
    log = shaken(nothing)
    levels = line_levels(log.prediction.innovations, log.record.valid, PART, 5e-4)
    assert levels is not None
    assert np.sqrt(np.mean(levels.distance**2)) == pytest.approx(1.0, abs=0.2)


def test_parts_with_missing_samples_are_left_out() -> None:
    valid = np.ones(4 * PERIOD, dtype=bool)
    valid[2 * PERIOD] = False
    assert line_levels(np.zeros((4 * PERIOD, 1)), valid, PART, 5e-4) is None
    log = shaken(nothing)
    assert locations(replace(log, record=replace(log.record, valid=valid))) == []


def test_shares_add_up() -> None:
    log = shaken(cubic)
    assert sum(location.share for location in locations(log)) == pytest.approx(1.0)


def test_multisines_of_a_diagnosis_experiment_are_found_where_they_repeat() -> None:
    experiment = Experiment.prepare(load_scenario("diagnosis"))
    parts = periodic_parts(experiment.trajectory, experiment.sample_time)
    assert len(parts) >= 3
    position = experiment.reference.motor_position
    for part in parts:
        first, second = (position[part.first + k * part.period :][: part.period] for k in (0, 1))
        assert np.abs(first - second).max() < 1e-3 * np.ptp(first)


def test_picture_shows_the_lines() -> None:
    log = shaken(cubic)
    data = SignatureData(log.robot, log.record, log.observer, log.prediction)
    assert DetectionLinePicture().picture(data, "motor_1") is None
    record = replace(log.record, parts=(PART,))
    found = DetectionLinePicture().picture(SignatureData(log.robot, record, log.observer, log.prediction), "motor_1")
    assert found is not None
    assert found.series["odd detection lines"].y.max() > 5
    assert found.series["even detection lines"].y.max() < 5


def test_lines_are_reported_with_the_other_locations() -> None:
    log = shaken(square)
    few = WhereSettings(realisations=30)
    found = where(log.prediction, replace(log.record, parts=(PART,)), log.robot, 1, settings=few)
    assert "even detection lines" in {location.signal for location in found.locations}
    assert "odd detection lines" not in {location.signal for location in found.locations}


@pytest.mark.parametrize(
    ("begin", "end", "expected"),
    [
        (0, 99_999, (PERIOD, 3)),
        (PERIOD, 4 * PERIOD, (0, 3)),
        (PERIOD + 1, 4 * PERIOD, (PERIOD - 1, 2)),
        (2 * PERIOD, 4 * PERIOD, (0, 2)),
        (100, 4 * PERIOD - 1, (PERIOD - 100, 2)),
        (2 * PERIOD + 1, 4 * PERIOD, None),
        (0, 3 * PERIOD - 1, None),
        (5 * PERIOD, 9 * PERIOD, None),
    ],
)
def test_whole_periods_of_a_cut_log_are_kept(begin: int, end: int, expected: tuple[int, int] | None) -> None:
    kept = PART.within(begin, end)
    assert (None if kept is None else (kept.first, kept.n_periods)) == expected
