"""What the checks of a record share."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.checks import checked_record
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
