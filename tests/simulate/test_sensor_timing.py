"""Delay and rate of further sensors: the same held values for a whole run, sample by sample and inside the loop."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot.further_sensors import FurtherSensor
from flexros.simulate.sensor_timing import SensorMemory, SensorTiming

TIMING = SensorTiming(delay=(0, 2, 3, 1), period=(1, 1, 4, 3))
VALUES = np.random.default_rng(1).standard_normal((30, 4))


def sensor(delay: float, rate: float | None) -> FurtherSensor:
    return FurtherSensor("link_position", "link position", "link_states", (0, 1), 0.0, (0.0, 0.0), delay, rate)


def test_held_values_come_from_earlier_samples() -> None:
    held = TIMING.held(VALUES)
    assert np.array_equal(held[:, 0], VALUES[:, 0])
    assert np.array_equal(held[:5, 1], VALUES[[0, 0, 0, 1, 2], 1])
    assert np.array_equal(held[:9, 2], VALUES[[0, 0, 0, 0, 1, 1, 1, 1, 5], 2])


def test_memory_gives_them_sample_by_sample() -> None:
    memory = SensorMemory(TIMING)
    seen = np.array([memory.add(k, row) for k, row in enumerate(VALUES)])
    assert np.array_equal(seen, TIMING.held(VALUES))


def test_a_controller_behind_the_timing_sees_them() -> None:
    c, r, y, g = ca.SX.sym("c", 1), ca.SX.sym("r", 0), ca.SX.sym("y", 6), ca.SX.sym("g", 0)
    law = TIMING.behind(ca.Function("law", [c, r, y, g], [y, c + 1]), n_motors=2)
    state, seen = np.zeros(1 + TIMING.memory_size), []
    for row in VALUES:
        u, after = law(state, [], [7.0, 8.0, *row], [])
        seen.append(u.full().ravel())
        state = after.full().ravel()
    assert np.array_equal(np.array(seen)[:, 2:], TIMING.held(VALUES))
    assert np.array_equal(np.array(seen)[:, :2], np.tile([7.0, 8.0], (30, 1)))
    assert state[0] == 30.0


def test_delay_and_rate_are_counted_in_samples() -> None:
    timing = SensorTiming.of([sensor(1e-3, 500.0)], 5e-4)
    assert (timing.delay, timing.period) == ((2, 2), (4, 4))
    assert SensorTiming.of([sensor(0.0, None)], 5e-4).is_immediate


@pytest.mark.parametrize(("delay", "rate", "text"), [(2e-4, None, "delay"), (0.0, 300.0, "rate"), (0.0, 4e3, "rate")])
def test_parts_of_samples_are_refused(delay: float, rate: float | None, text: str) -> None:
    with pytest.raises(InputError, match=rf"sensors\.link\.{text}"):
        SensorTiming.of([sensor(delay, rate)], 5e-4)
