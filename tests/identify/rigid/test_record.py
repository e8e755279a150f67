"""Torques at the instants of the positions."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.rigid.record import torque_as_it_acts, torque_at_samples
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.robot import Robot

N = 200
STAMP = stamps_ns(N, 1e-3)
ONE = ("motor_1",)


def column(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(N, 1))


def record_of(robot: Robot, effort: np.ndarray | None = None, commands: slice = np.s_[:]) -> Record:
    states = JointSeries(STAMP, ONE, position=column(1), effort=effort)
    log = Log(states, JointSeries(STAMP[commands], ONE, effort=column(2)[commands]))
    return read_record(log, robot, name="log", torque="command" if effort is None else "measured")


def test_measured_torque_is_that_of_the_sample(emps: Robot) -> None:
    np.testing.assert_array_equal(torque_at_samples(record_of(emps, column(3))), column(3))


def test_missing_measured_torque_is_bridged(emps: Robot) -> None:
    effort = column(3)
    effort[50] = np.nan
    torque = torque_at_samples(record_of(emps, effort))
    np.testing.assert_allclose(
        torque[49:51, 0], [effort[48, 0] + (effort[51, 0] - effort[48, 0]) * k / 3 for k in (1, 2)]
    )


def test_command_of_the_same_sample(emps: Robot) -> None:
    np.testing.assert_array_equal(torque_at_samples(record_of(emps)), column(2))


def test_slower_commands_are_held(emps: Robot) -> None:
    torque = torque_at_samples(record_of(emps, commands=np.s_[10::4]))
    np.testing.assert_allclose(torque[:8, 0], np.repeat(column(2)[[10, 14], 0], 4), atol=1e-9)


@pytest.mark.parametrize(("delay", "begin"), [(0.0, 1), (1e-3, 2), (4e-4, 1), (6e-4, 2)])
def test_command_as_it_acts_is_the_mean_around_the_sample(emps: Robot, delay: float, begin: int) -> None:
    torque, first = torque_as_it_acts(record_of(emps), delay)
    fine = np.repeat(column(2)[:, 0], 1000)  # 1 us steps
    middle = round(1e6 * (0.1 - delay))
    assert first == begin
    assert torque[100, 0] == pytest.approx(fine[middle - 500 : middle + 500].mean())
