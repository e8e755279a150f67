"""Logs of other rates: a holdout of another one, and servo logs."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.errors import InputError
from flexros.gap.diagnose import diagnose
from flexros.gap.measure_gap import measure_gap
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from flexros.record.resampled import resampled
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import ROBOT, record_of, settings_of

FRICTION = "coulomb_friction@motor_1:level=0.05"

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("interval", [0.98, 1.15])
def test_a_holdout_of_a_slightly_other_rate_is_resampled(interval: float) -> None:
    record, other = record_of(FRICTION), resampled(record_of(FRICTION, seed=2), interval * ROBOT.sample_time)
    result = diagnose(record, ROBOT, holdout=other, settings=settings_of("coulomb_friction", "viscous_friction"))
    (cause,) = result.diagnosis.causes
    assert cause.effect == "coulomb_friction"
    assert cause.parameters["level"].value == pytest.approx(0.05, rel=0.05)
    assert result.diagnosis.gap.closed_fraction > 0.9


def test_a_holdout_of_a_slightly_lower_rate_shows_no_gap_where_there_is_none() -> None:
    other = resampled(record_of(seed=2), 1.15 * ROBOT.sample_time)
    result = diagnose(record_of(), ROBOT, holdout=other, settings=settings_of("coulomb_friction", "viscous_friction"))
    assert result.diagnosis.verdict == "no_gap"
    assert result.diagnosis.gap.before < 1.1


def test_a_holdout_of_a_much_lower_rate_is_refused() -> None:
    record = record_of()
    with pytest.raises(InputError, match="exchange the two"):
        diagnose(record, ROBOT, holdout=resampled(record_of(seed=2), 2 * ROBOT.sample_time), settings=settings_of())


def slow_log(sample_time: float, friction: float) -> Record:
    """Let a rigid drive swing under forces that are held over each sample."""
    rng, n, T = np.random.default_rng(1), round(60.0 / sample_time), sample_time
    rate = (DAMPING + friction) / MASS
    decay = np.exp(-rate * T)
    time, position, force = np.arange(n) * T, np.zeros(n), np.zeros(n)
    goal = sum(a * np.sin(2 * np.pi * hertz * time) for a, hertz in ((0.04, 0.31), (0.02, 0.53), (0.01, 0.83)))
    x = v = 0.0
    for k in range(n):
        position[k] = x
        force[k] = 4000.0 * (goal[k] - x) - 400.0 * v
        steady = force[k] / MASS / rate
        x, v = x + steady * T + (v - steady) * (1 - decay) / rate, steady + (v - steady) * decay
    return Record(
        name="log",
        sample_time=T,
        position=(position + 1e-6 * rng.normal(size=n))[:, None],
        torque=force[:, None],
        valid=np.ones(n, dtype=bool),
    )


EMPS = load_robot("emps")
MASS, DAMPING = (float(EMPS.parameters[name].value) for name in ("body_1.mass", "motor_1.viscous_friction"))


@pytest.mark.parametrize("rate", [50.0, 20.0])
def test_servo_logs_have_the_gap_of_their_robot(rate: float) -> None:
    model, settings = RobotWithEffects(EMPS, ()), DiagnosisSettings()
    exact, other = (measure_gap(slow_log(1 / rate, extra), model, settings=settings) for extra in (0.0, 100.0))
    assert not exact.significant
    assert exact.numbers.before < 1.5
    assert other.significant
    assert other.numbers.before > 1000.0
