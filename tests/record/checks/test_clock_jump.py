"""Clocks of recordings that jump."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.record.checks.base import Finding
from flexros.record.checks.clock_jump import ClockJump
from flexros.record.record import Record

T, N, NOISE = 0.002, 4000, 6e-6


def recorded(ahead: FloatArray, *, imported: bool = True, motors: int = 3) -> Record:
    """Record a motion at instants that are ahead of their stamps [samples]."""
    time = T * (np.arange(N) + ahead)
    lines = [np.sin((1.3 + 0.4 * motor) * time + motor) + 0.3 * np.sin(3.1 * time) for motor in range(motors)]
    position = np.stack(lines, axis=1) + NOISE * np.random.default_rng(1).standard_normal((N, motors))
    return Record("log", T, position, np.zeros_like(position), np.ones(N, dtype=bool), imported=imported)


def found(record: Record) -> tuple[Finding, ...]:
    return ClockJump().look(SimpleNamespace(record=record))  # type: ignore[arg-type]


def after(*jumps: tuple[int, float]) -> FloatArray:
    ahead = np.zeros(N)
    for sample, size in jumps:
        ahead[sample:] += size
    return ahead


@pytest.mark.parametrize("size", [0.125, -0.125, 1.0, -1.0, 3.0])
def test_a_jump_of_the_clock_is_found_with_its_size(size: float) -> None:
    (finding,) = found(recorded(after((1500, size))))
    assert not finding.hopeless
    assert finding.jumps is not None
    assert np.flatnonzero(finding.jumps).tolist() == [1500]
    assert finding.jumps[1500] == pytest.approx(size, rel=0.15)


def test_one_stamp_that_is_off_is_found_on_both_sides() -> None:
    ahead = np.zeros(N)
    ahead[2000] = -1.0
    (finding,) = found(recorded(ahead))
    assert finding.jumps is not None
    assert set(np.flatnonzero(finding.jumps).tolist()) <= {2000, 2001}


def test_an_even_clock_and_one_that_jitters_have_none() -> None:
    jitter = 0.2 * np.random.default_rng(2).standard_normal(N)
    assert not found(recorded(np.zeros(N)))
    assert not found(recorded(jitter))


def test_an_encoder_that_errs_alone_and_an_impact_are_no_jumps() -> None:
    record = recorded(np.zeros(N))
    alone, hit = record.position.copy(), record.position.copy()
    alone[1500, 1] += 0.01
    hit[1500:] += 0.2 * T * np.arange(N - 1500)[:, None] * np.array([1.0, -2.0, 0.5])
    assert not found(replace(record, position=alone))
    assert not found(replace(record, position=hit))


def test_speeds_that_torques_change_at_once_are_no_jump() -> None:
    """In a stiff arm a step of all commands nearly doubles all speeds within two samples."""
    record = recorded(np.zeros(N))
    steps = np.diff(record.position, axis=0)
    steps[1998:] += steps[1998] * np.array([-0.15, 0.9, 1.75, *np.full(N - 2002, 1.6)])[:, None]
    position = np.vstack([record.position[:1], record.position[0] + np.cumsum(steps, axis=0)])
    assert not found(replace(record, position=position))


def test_a_motion_that_begins_at_rest_is_no_jump() -> None:
    """A sampling interval of 40 ms: the first steps are small beside those that follow."""
    time = np.maximum(0.04 * np.arange(600) - 1.2, 0.0)
    position = np.stack([(1 - np.exp(-3 * time**3)) * np.sin((0.7 + 0.2 * k) * time) for k in range(3)], axis=1)
    record = Record("log", 0.04, position, np.zeros_like(position), np.ones(600, dtype=bool), imported=True)
    assert not found(record)


def test_logs_of_this_program_are_not_asked_nor_those_of_one_joint() -> None:
    assert not found(recorded(after((1500, 1.0)), imported=False))
    assert not found(recorded(after((1500, 1.0)), motors=1))
