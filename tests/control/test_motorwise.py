"""What control laws share that treat each motor for itself."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import AbstractControlLaw, control_law, control_laws
from flexros.control.motorwise import AbstractMotorwiseLaw

LAWS = [
    control_law({"kind": "pid", "kp": [10.0, 20.0], "ki": 500.0, "torque_limit": [25.0, 40.0]}),
    control_law({"kind": "cascade", "position_gain": [10.0, 20.0], "speed_gain": 1.0, "torque_limit": [25.0, 40.0]}),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_gains_stand_motor_by_motor_behind_one_another(law: AbstractControlLaw) -> None:
    assert isinstance(law, AbstractMotorwiseLaw)
    gains = dict(zip(law.gain_names(2), law.gains(2, np.array([20.0, 50.0])), strict=True))
    assert [gains[f"motor_{motor}.{law.gain_keys[0]}"] for motor in (1, 2)] == [10.0, 20.0]
    assert [gains[f"motor_{motor}.torque_limit"] for motor in (1, 2)] == [20.0, 40.0]  # the lower one of both
    assert len(gains) == 2 * (len(law.gain_keys) + 1)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_first_sample_has_no_rate(law: AbstractControlLaw) -> None:
    update = law.function(2, 1e-3)
    gains = law.gains(2)
    _, memory = update(law.initial_state(2), [0.4, 0.1, 0, 0, 0, 0], [0.3, 0.5], gains)
    assert np.asarray(memory).ravel()[2:4].tolist() == [0.0, 0.0]
    assert float(np.asarray(memory).ravel()[-1]) == 1.0


def test_the_base_itself_is_no_control_law() -> None:
    assert AbstractMotorwiseLaw not in control_laws().values()
