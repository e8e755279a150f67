"""Influences that the model of one axis lacks."""

from __future__ import annotations

import numpy as np

from flexros.identify.axis.identification import unmodelled
from flexros.logs.time_series import JointSeries, Log
from flexros.record.read import read_record
from flexros.robot import load_robot


def found_in(name: str, *amplitudes: float) -> tuple[str, ...]:
    time = np.arange(1000) * 1e-3
    position = np.sin(10 * time)[:, None] * np.array(amplitudes)
    names = tuple(f"motor_{number}" for number in range(1, len(amplitudes) + 1))
    stamp = np.arange(1000) * 1_000_000
    log = Log(JointSeries(stamp, names, position=position), JointSeries(stamp, names, effort=100 * position))
    robot = load_robot(name)
    return unmodelled(read_record(log, robot, name="log"), robot, 0)


def test_axis_alone_has_no_other_influence() -> None:
    assert found_in("two_mass", 0.1) == ()


def test_gravity_is_reported() -> None:
    (warning,) = found_in("elbow", 0.1, 0.0)
    assert warning.startswith("gravity loads motor_1 by ")


def test_other_motor_that_moves_is_named() -> None:
    (warning,) = found_in("e12", 0.1, 0.02)
    assert "but motor_2 moves too; move motor_1 alone" in warning
    assert found_in("e12", 0.1, 0.001) == ()
