"""Common properties of control laws that control each motor separately."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import AbstractControlLaw, control_law, control_laws
from flexros.control.motorwise import AbstractMotorwiseLaw
from tests.control.loop_contexts import loop_context

LAWS = [
    control_law({"kind": "pid", "kp": [10.0, 20.0], "ki": 500.0, "torque_limit": [25.0, 40.0]}),
    control_law({"kind": "cascade", "position_gain": [10.0, 20.0], "speed_gain": 1.0, "torque_limit": [25.0, 40.0]}),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_gains_stand_motor_by_motor_behind_one_another(law: AbstractControlLaw) -> None:
    assert isinstance(law, AbstractMotorwiseLaw)
    context = loop_context(2, 1e-3, [20.0, 50.0])
    gains = dict(zip(law.gain_names(context), law.gains(context), strict=True))
    assert [gains[f"motor_{motor}.{law.gain_keys[0]}"] for motor in (1, 2)] == [10.0, 20.0]
    assert [gains[f"motor_{motor}.torque_limit"] for motor in (1, 2)] == [20.0, 40.0]  # the lower one of both
    assert len(gains) == 2 * (len(law.gain_keys) + 1)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_first_sample_has_no_rate(law: AbstractControlLaw) -> None:
    context = loop_context(2, 1e-3)
    update, gains = law.function(context), law.gains(context)
    _, memory = update(law.initial_state(context), [0.4, 0.1, 0, 0, 0, 0], [0.3, 0.5], gains)
    assert np.asarray(memory).ravel()[2:4].tolist() == [0.0, 0.0]
    assert float(np.asarray(memory).ravel()[-1]) == 1.0


def test_the_base_itself_is_no_control_law() -> None:
    assert AbstractMotorwiseLaw not in control_laws().values()
