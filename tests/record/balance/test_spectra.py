"""Spectra of torques and motions of a log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.record.balance import spectra
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


def test_a_long_record_is_transformed_without_its_last_samples_where_its_length_has_a_large_prime(monkeypatch) -> None:
    robot, rng, n = load_robot("emps"), np.random.default_rng(2), 12_011 + 2  # 12,011 is a prime
    position, torque = np.cumsum(rng.normal(size=(2, n, 1)), axis=1) * 1e-4
    record = Record("log", 0.001, position, torque, np.ones(n, dtype=bool))
    whole = torque_balance(record, robot)
    monkeypatch.setattr(spectra, "_LONG", 10_000)
    assert spectra._transformed(12_011) == 12_000
    assert spectra._transformed(9_973) == 9_973
    shorter = torque_balance(record, robot)
    assert whole is not None
    assert shorter is not None
    stretches = whole.frequency >= 1.0
    np.testing.assert_array_equal(shorter.given[shorter.frequency >= 1.0], whole.given[stretches])
    assert 0.9 < np.sum(np.abs(shorter.given) ** 2) / np.sum(np.abs(whole.given) ** 2) < 1.1
