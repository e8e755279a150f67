"""Torques that belong to other motors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.record.balance.torque_balance import BalanceFit
from flexros.record.checks.checked_record import CheckedRecord
from flexros.robot import load_robot
from tests.ur5e import ur5e, ur5e_record


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

    def __init__(self, own: tuple[float, float], others: tuple[float, float], explained: float = 0.5) -> None:
        self.factors = {(0, 0): own[0], (1, 1): own[1], (0, 1): others[0], (1, 0): others[1]}
        self.own = explained

    def fit(self, torque: int, motion: int) -> BalanceFit:
        agreement = 0.2 if torque == motion else 0.95
        return BalanceFit(self.factors[torque, motion], agreement, agreement, agreement, 1.0)

    def unexplained(self, torque: int, motion: int) -> float:
        return 1 - self.own if torque == motion else 0.5


@pytest.mark.parametrize(
    ("own", "others", "explained", "wrong"),
    [
        ((0.2, 5.0), (1.1, 0.9), 0.5, True),
        ((1.0, 1.1), (7.0, 0.6), 0.5, False),
        ((1.1, -1.2), (1.2, 1.1), 0.5, True),
        ((1.1, -1.2), (1.2, 1.1), 0.8, False),
    ],
    ids=["torques of the other's size", "loads that vary alike", "motors alike", "explained better where they are"],
)
def test_a_torque_many_times_as_large_or_that_its_own_motion_explains_belongs_to_no_other_motor(
    healthy, own: tuple[float, float], others: tuple[float, float], explained: float, wrong: bool
) -> None:
    checked = CheckedRecord(healthy("e12"), load_robot("e12"))
    checked.__dict__["balance"] = Compared(own, others, explained)  # what is computed once
    assert checked.order_is_wrong is wrong


@pytest.mark.parametrize(
    ("shares", "wrong"),
    [
        ([[0.9, 0.1], [0.2, 0.8]], True),
        ([[0.2, 0.1], [0.1, 0.2]], False),
        ([[0.99, 0.1], [0.4, 0.99]], False),
        ([[0.1, 0.9], [0.05, 0.2]], False),
    ],
    ids=["swapped", "loads that vary alike", "badly explained elsewhere", "one motion explains both"],
)
def test_torques_belong_elsewhere_where_far_less_of_all_of_them_is_unexplained(
    healthy, shares: list[list[float]], wrong: bool
) -> None:
    checked = CheckedRecord(healthy("e12"), load_robot("e12"))
    checked.__dict__["unexplained"] = np.array(shares)  # what is computed once
    assert checked.order_is_wrong is wrong


@pytest.mark.parametrize("swapped", [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5)])
def test_swapped_torques_show_beside_a_load_and_rotors_that_the_robot_file_lacks(swapped: tuple[int, int]) -> None:
    record = ur5e_record()
    assert not CheckedRecord(record, ur5e()).order_is_wrong
    order = np.arange(6)
    order[list(swapped)] = swapped[::-1]
    checked = CheckedRecord(replace(record, torque=record.torque[:, order]), ur5e())
    assert checked.order == tuple(order)
    assert checked.order_is_wrong
