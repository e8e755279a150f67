"""What the model of one axis lacks is said."""

from __future__ import annotations

import numpy as np

from flexros.identify.axis.unmodelled import unmodelled
from flexros.logs.time_series import JointSeries, Log
from flexros.robot import load_robot


def log_of(*amplitudes: float) -> Log:
    time = np.arange(1000) * 1e-3
    position = np.sin(10 * time)[:, None] * np.array(amplitudes)
    names = tuple(f"motor_{number}" for number in range(1, len(amplitudes) + 1))
    stamp = np.arange(1000) * 1_000_000
    return Log(JointSeries(stamp, names, position=position), JointSeries(stamp, names, effort=100 * position))


def test_axis_alone_has_nothing_beside_it() -> None:
    assert unmodelled(log_of(0.1), load_robot("two_mass"), "motor_1") == ()


def test_gravity_is_told() -> None:
    (told,) = unmodelled(log_of(0.1, 0.0), load_robot("elbow"), "motor_1")
    assert told.startswith("gravity loads motor_1 by ")


def test_other_motor_that_moves_is_named() -> None:
    (told,) = unmodelled(log_of(0.1, 0.02), load_robot("e12"), "motor_1")
    assert "but motor_2 moves too; move motor_1 alone" in told
    assert unmodelled(log_of(0.1, 0.001), load_robot("e12"), "motor_1") == ()
