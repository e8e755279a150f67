"""What the checks of a record share."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.checks import checked_record, foreign_torque, unit
from flexros.record.checks.checked_record import SLOW, CheckedRecord


def test_torque_of_the_rigid_arm_is_computed_once_per_frequency(
    healthy, robots, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[float] = []
    robot = robots("elbow")

    def counted(*arguments: object) -> np.ndarray:
        if arguments[0] is robot:  # not the one without friction, whose torque is that of the bodies
            asked.append(arguments[-1])
        return rigid_inverse_dynamics(*arguments)

    monkeypatch.setattr(checked_record, "rigid_inverse_dynamics", counted)
    checked = CheckedRecord(healthy("elbow", whole=True), robot)
    agreement, _ = checked.over_all
    first, faster = checked.rigid_torque(), checked.rigid_torque(20.0)
    assert checked.rigid_torque() is first
    assert checked.rigid_torque(20.0) is faster
    assert asked == [SLOW, 20.0]
    assert np.all(agreement > 0.9)


def test_slow_torques_of_a_long_log_need_few_samples_and_little_memory(
    healthy, robots, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those of 30 min at 2 kHz had been the largest memory of a diagnosis."""
    record, robot = healthy("elbow", whole=True), robots("elbow")
    whole, few = (CheckedRecord(record, robot) for _ in range(2))
    told = foreign_torque._unexplained(whole), foreign_torque._weight_left(whole), unit._factors_beside_drives(whole)
    monkeypatch.setattr(checked_record, "MOST_SLOW", record.n_samples // 10)
    assert few.slow_step == 10
    assert np.allclose(foreign_torque._unexplained(few), told[0], rtol=0.05, atol=1e-3)
    assert np.allclose(foreign_torque._weight_left(few), told[1], rtol=0.05, atol=1e-3)
    assert unit._factors_beside_drives(few) == pytest.approx(told[2], rel=0.05)
    tracemalloc.start()
    CheckedRecord(record, robot).slow_parts  # noqa: B018
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 12 * record.position.nbytes
