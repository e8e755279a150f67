"""Settings that are given once for all motors, or one by one."""

from __future__ import annotations

import pytest

from flexros.config.per_motor import per_motor
from flexros.errors import InputError


def test_one_value_holds_for_all_motors() -> None:
    assert per_motor("controller.kp", 2.0, 3).tolist() == [2.0, 2.0, 2.0]


def test_values_one_by_one_are_kept() -> None:
    assert per_motor("controller.kp", (1.0, 2.0), 2).tolist() == [1.0, 2.0]


def test_spread_values_do_not_share_memory() -> None:
    values = per_motor("controller.kp", 2.0, 2)
    values[0] = 5.0
    assert values.tolist() == [5.0, 2.0]


def test_another_number_of_values_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"^controller\.kp has 3 values, allowed is one, or one for each of the 2 motors; correct it$"
    ):
        per_motor("controller.kp", (1.0, 2.0, 3.0), 2)
