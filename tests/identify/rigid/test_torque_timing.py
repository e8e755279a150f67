"""When the measured torques of a log acted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.identify.rigid.torque_timing import with_torque_in_time
from flexros.record.record import Record
from flexros.record.torques.shifted_torque import shifted
from flexros.robot import Robot, load_robot

T, INERTIA = 0.004, 0.5
ROBOT = f"""
name: wheel
sample_time: {T}
bodies: [{{inertia: {{yy: 0.1}}, directions: {{ry: {{spring: rigid, motor: {{inertia: {INERTIA - 0.1}}}}}}}}}]
outputs: {{joints: {{coordinates: [body_1.ry]}}}}
controlled: joints
"""


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    file = tmp_path / "wheel.yaml"
    file.write_text(ROBOT)
    return load_robot(file)


def log(noted: float, imported: bool = True) -> Record:
    """Return a log of a wheel; the middle of the sample in which a torque acts is `noted` samples after its stamp."""
    fine, n = 20, 2500
    rng = np.random.default_rng(0)
    frequencies, phases = rng.uniform(0.3, 3.0, 6), rng.uniform(0, 2 * np.pi, 6)
    torque = np.sin(2 * np.pi * frequencies * T * np.arange(n + 2)[:, None] + phases).sum(axis=1)
    acting = np.repeat(torque, fine) / INERTIA
    step = T / fine
    speed = np.concatenate([[0.0], np.cumsum(acting) * step])[:-1]
    place = np.concatenate([[0.0], np.cumsum(speed * step + 0.5 * acting * step**2)])[:-1]
    position = place[::fine][1 : n + 1, None] + 1e-6 * rng.normal(size=(n, 1))
    before, after = torque[:n, None], torque[1 : n + 1, None]  # what acts before and after each position
    effort = {-0.5: before, 0.0: (before + after) / 2, 0.5: after}[noted]
    mean = (effort + np.vstack([effort[1:], effort[-1:]])) / 2
    valid = np.ones(n, dtype=bool)
    return Record("log", T, position, mean, valid, noted=effort, measured_torque=True, imported=imported)


@pytest.mark.parametrize("shift", [-0.5, 0.5])
def test_held_torques_are_found_half_a_sample_from_their_stamps(robot: Robot, shift: float) -> None:
    record = with_torque_in_time(log(shift), robot)
    assert record.torque_shift == shift
    assert "half a sample" in record.warnings[-1]


def test_torques_of_their_stamps_and_of_own_logs_stay(robot: Robot) -> None:
    assert with_torque_in_time(log(0.0), robot).torque_shift == 0.0
    assert with_torque_in_time(log(0.5, imported=False), robot).torque_shift == 0.0


def test_shift_moves_the_mean_and_back() -> None:
    record = log(0.5)
    assert record.noted is not None
    np.testing.assert_array_equal(shifted(record, 0.5).torque, record.noted)
    np.testing.assert_array_equal(shifted(record, -0.5).torque[:-1], record.noted[1:])
    np.testing.assert_array_equal(shifted(shifted(record, 0.5), 0.0).torque, record.torque)
