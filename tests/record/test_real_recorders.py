"""Logs of real recorders, which are not in this repository: what was refused or misread."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.noise.encoder_noise import measure_noise
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.gap.settings.log import NoiseSettings
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.record.checks.run import findings
from flexros.record.quantization import lattice_step
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.record.smoothing import smooth_motion
from flexros.robot import Robot, load_robot

FOLDER = Path(os.environ.get("FLEXROS_REALDATA") or "/nowhere")
PENDULUM, LINKS = FOLDER / "dfki_double_pendulum", FOLDER / "quanser_2dsfl"
pytestmark = pytest.mark.skipif(
    not (PENDULUM.is_dir() and LINKS.is_dir()),
    reason="FLEXROS_REALDATA is unset or lacks dfki_double_pendulum/ and quanser_2dsfl/, the measured robots",
)


@cache
def recorded(folder: Path, file: str, mapping: str, robot: str) -> tuple[Record, Robot]:
    model = load_robot(folder / robot)
    return read_record(import_log(load_mapping(folder / mapping), [folder / file]), model, name=file), model


def test_one_lost_command_leaves_a_log_of_which_slow_modes_settle_for_seconds() -> None:
    record, robot = recorded(PENDULUM, "C_143704.csv", "mapping.yaml", "robot_without_friction.yaml")
    exact = DiagnosisSettings(noise=NoiseSettings(signal_tolerance=0.0))
    data = fit_data(record, RobotWithEffects(robot, ()), exact)
    assert data.gain.settling > 0.9 * record.n_samples
    assert data.counted.mean() > 0.99


def test_a_pendulum_at_rest_is_not_stuck() -> None:
    record, robot = recorded(PENDULUM, "C_143906.csv", "mapping.yaml", "robot_without_friction.yaml")
    assert not any("repeats its value" in finding.text for finding in findings(record, robot))


@pytest.mark.parametrize("stage", [1, 2])
def test_drives_that_turn_slowly_are_not_clipped(stage: int) -> None:
    for file in ("lqr.csv", "fsf.csv"):
        record, robot = recorded(LINKS, file, f"mapping_stage{stage}.yaml", f"robot_stage{stage}.yaml")
        n = 1250
        for first in range(0, record.n_samples - n, n):
            texts = [finding.text for finding in findings(record.part(first, first + n), robot)]
            assert not any("stays at the end" in text for text in texts)


@pytest.mark.parametrize(("stage", "counts"), [(1, 409_600), (2, 204_800)])
def test_resolution_of_an_encoder_is_found_in_decimals(stage: int, counts: int) -> None:
    record, _ = recorded(LINKS, "lqr.csv", f"mapping_stage{stage}.yaml", f"robot_stage{stage}.yaml")
    step = lattice_step(record.position[:, 0])
    assert step == pytest.approx(2 * np.pi / counts, rel=1e-3)


@pytest.mark.slow
def test_noise_that_grows_with_speed_is_not_the_rounding_of_a_coarse_encoder() -> None:
    record, robot = recorded(PENDULUM, "C_143601.csv", "mapping.yaml", "robot_without_friction.yaml")
    step = lattice_step(record.position[:, 0])
    assert step is not None
    smooth = smooth_motion(record.position, record.sample_time, 50.0)[0]
    rounded = replace(record, position=step * np.rint(smooth / step))
    measured, made = (measure_noise(one, robot, DiagnosisSettings()).jitter for one in (record, rounded))
    assert measured > 2e-5
    assert made == 0.0


def test_a_log_of_ten_seconds_is_not_called_short() -> None:
    record, robot = recorded(PENDULUM, "C_143601.csv", "mapping.yaml", "robot_without_friction.yaml")
    assert record.duration < 10.0
    assert not any("below 10 s" in finding.text for finding in findings(record, robot))
