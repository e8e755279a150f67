"""Torques that belong to other motors."""

from __future__ import annotations

import pytest

from flexros.record.balance.torque_balance import BalanceFit
from flexros.record.checks.checked_record import CheckedRecord
from flexros.robot import load_robot


@pytest.mark.parametrize("robot", ["e12", "elbow"])
def test_swapped_torques_are_named(found, healthy, robot: str) -> None:
    findings = found(robot, torque=healthy(robot).torque[:, ::-1])
    assert findings[0].hopeless
    assert findings[0].text == (
        "joints are swapped between torques and positions: the torque called motor_1 belongs to the motion of motor_2, "
        "the torque called motor_2 belongs to the motion of motor_1; correct the names when importing"
    )


class Compared:
    """A balance in which each torque agrees best with what the other motor needs, at some multiple."""

    def __init__(self, own: tuple[float, float], others: tuple[float, float]) -> None:
        self.factors = {(0, 0): own[0], (1, 1): own[1], (0, 1): others[0], (1, 0): others[1]}

    def fit(self, torque: int, motion: int) -> BalanceFit:
        agreement = 0.2 if torque == motion else 0.95
        return BalanceFit(self.factors[torque, motion], agreement, agreement, agreement, 1.0)


@pytest.mark.parametrize(
    ("own", "others", "wrong"),
    [((0.2, 5.0), (1.1, 0.9), True), ((1.0, 1.1), (7.0, 0.6), False), ((1.1, -1.2), (1.2, 1.1), True)],
    ids=["torques of the other's size", "loads that vary alike", "motors alike"],
)
def test_a_torque_many_times_as_large_belongs_to_no_other_motor(
    healthy, own: tuple[float, float], others: tuple[float, float], wrong: bool
) -> None:
    checked = CheckedRecord(healthy("e12"), load_robot("e12"))
    checked.__dict__["balance"] = Compared(own, others)  # what is computed once
    assert checked.order == (1, 0)
    assert checked.order_is_wrong is wrong
