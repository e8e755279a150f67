"""Spectra of torques and motions of a log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.record.balance.spectra import torque_balance
from flexros.record.record import Record
from flexros.robot import load_robot


def test_what_a_log_holds_in_a_long_hole_does_not_matter() -> None:
    robot, rng, n = load_robot("emps"), np.random.default_rng(1), 12_000
    position, torque = np.cumsum(rng.normal(size=(2, n, 1)), axis=1) * 1e-4
    valid = np.abs(np.arange(n) - n // 2) > 1_000
    record = Record("log", 0.001, position, torque, valid)
    balance = torque_balance(record, robot)
    other = torque_balance(replace(record, torque=np.where(valid[:, None], torque, 1e3)), robot)
    assert balance is not None
    assert other is not None
    np.testing.assert_array_equal(balance.given, other.given)
    assert np.all(np.isfinite(balance.given))
