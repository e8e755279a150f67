"""Speeds by differences: of the deviation from the reference, so that the motion itself is not delayed."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.control.context import LoopContext
from flexros.control.limited import LoopSignals
from flexros.control.observers.differences import Differences
from flexros.errors import InputError
from flexros.robot import load_robot

STEP = 5e-4


def speeds(motion_rate: float, deviation_rate: float, speed_filter: float, samples: int) -> np.ndarray:
    """Return the estimated speed of motor 1 while reference and deviation move evenly, shape (samples,)."""
    context = LoopContext(load_robot("elbow_sensors"), STEP, link_motion=True)
    observer = Differences(speed_filter=speed_filter)
    c = casadi.SX.sym("c", observer.state_size(context))
    r, y = casadi.SX.sym("r", context.references.size), casadi.SX.sym("y", context.measurements.size)
    gains = {name: casadi.SX(value) for name, value in observer.gains(context).items()}
    found, after = observer.estimate(c, LoopSignals(context, r, y), gains)
    step = casadi.Function("step", [c, r, y], [found.motor_velocity, after(casadi.SX.zeros(2))])
    state, values = np.zeros(c.numel()), []
    for sample in range(samples):
        reference, measured = np.zeros(r.numel()), np.zeros(y.numel())
        reference[context.references.rows("motor_position")] = motion_rate * sample * STEP
        reference[context.references.rows("motor_velocity")] = motion_rate
        measured[context.measurements.rows("motor_position")] = (motion_rate + deviation_rate) * sample * STEP
        speed, state = step(state, reference, measured)
        values.append(float(speed[0]))
    return np.array(values)


def test_speed_of_the_reference_is_known_at_once_whatever_the_filter() -> None:
    assert speeds(2.0, 0.0, 0.05, 5) == pytest.approx(np.full(5, 2.0))


def test_rate_of_the_deviation_is_exact_without_filter_and_comes_with_its_time_constant_with_it() -> None:
    assert speeds(2.0, 0.3, 0.0, 4)[1:] == pytest.approx(np.full(3, 2.3))
    filtered = speeds(2.0, 0.3, 10 * STEP, 60)
    share = (filtered[1:] - 2.0) / 0.3
    assert share == pytest.approx(1.0 - (10.0 / 11.0) ** np.arange(1, 60))


def test_robot_without_link_encoders_is_refused() -> None:
    with pytest.raises(InputError, match=r"sensors\.link\.position"):
        Differences().check(LoopContext(load_robot("elbow"), STEP, link_motion=True))
