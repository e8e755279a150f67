"""Transients in recorded periods."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.identify.frf.checks.settling import check_settled
from flexros.identify.frf.experiments import Experiments

N = 500


def record(transient: float, n_periods: int = 2) -> Experiments:
    rng = np.random.default_rng(0)
    t = np.arange(n_periods * N) / N
    periodic = np.cos(2 * np.pi * np.outer(t, np.arange(1, 80, 2)) + 3 * np.arange(40)).sum(axis=1)
    y = periodic + 0.3 * t + 0.01 * rng.standard_normal((2, len(t))) + transient * np.exp(-2 * t) * np.cos(40 * t)
    return Experiments.of(y, y, 1e-3, n_periods=n_periods, lines=np.arange(1, 80, 2), label="position 1")


def test_noise_on_a_drift_is_settled() -> None:
    assert check_settled(record(0.0), 2) == []
    assert check_settled(record(0.0, n_periods=4), 2) == []


def test_transient_is_warned_of() -> None:
    text = check_settled(record(0.5), 2)[0]
    assert text.startswith("position 1: not settled: the change of the position of motor_1 between periods decays")
    assert text.endswith("add transient_periods, or set method to local_polynomial, which models it")


def test_one_period_has_no_covariance() -> None:
    assert check_settled(record(0.5, n_periods=1), 2) == []


def test_exact_periods_are_settled() -> None:
    mine = record(0.0)
    exact = np.tile(mine.outputs[:, :N], (1, 2, 1))
    assert check_settled(replace(mine, inputs=exact, outputs=exact), 2) == []
