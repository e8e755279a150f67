"""Sizes of what is hidden: what a tolerance explains at its prior does not count."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.validation.blind.deviation import Deviation
from flexros.validation.blind.draw.nominal_filter import NominalFilter
from flexros.validation.blind.draw.sizing import changed_numbers

ROBOT = load_robot("four_mass_linear")


def deviation(effect: str, location: str) -> Deviation:
    return Deviation(effect=effect, location=location, parameters={"relative": 0.2})


def test_errors_of_numbers_change_these_and_laws_none() -> None:
    assert changed_numbers(deviation("stiffness_error", "body_2.rz"), ROBOT) == {"body_2.rz.stiffness": 1.2}
    assert changed_numbers(deviation("motor_inertia_error", "motor_1"), ROBOT) == {"motor_1.inertia": 1.2}
    load = changed_numbers(deviation("payload_error", "tool"), ROBOT)
    assert set(load) <= set(ROBOT.parameters)
    assert {"body_3.inertia.zz"} <= set(load)
    assert changed_numbers(deviation("backlash", "motor_1"), ROBOT) == {}


def test_the_price_of_a_change_is_that_of_its_deviations() -> None:
    known = NominalFilter(ROBOT, ROBOT.sample_time, {"body_2.rz.stiffness": 0.03, "motor_1.inertia": 0.01})
    assert known.price({"body_2.rz.stiffness": 1.2}) == pytest.approx((np.log(1.2) / 0.03) ** 2 / 2)
    assert known.price({"body_1.rz.stiffness": 1.2}) == np.inf
    assert known.price({}) == np.inf
