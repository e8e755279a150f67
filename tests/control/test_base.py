"""Finding control laws by name, and what every one of them must keep."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import AbstractControlLaw, control_law, control_laws
from flexros.control.pid import Pid
from flexros.errors import InputError
from tests.control.loop_contexts import loop_of

SETTINGS = {
    "cascade": {"position_gain": 3.0, "speed_gain": 2.0, "integral_gain": 1.0},
    "pid": {"kp": 3.0, "ki": 2.0, "kd": 1.0},
    "state_space": {"A": [[0.5]], "B": [[1.0]], "C": [[2.0]], "D": [[3.0]]},
}
SETTINGS |= {
    "computed_torque": {"kp": 3.0, "kd": 1.0},
    "feedback_linearisation": {"bandwidth": 3.0},
    "lqg": {"effort": 1.0, "torque_noise": 1.0, "motor_accuracy": 1e-3, "loop_gain": 3.0},
    "torque_feedback": {"kp": 3.0, "kd": 1.0, "kt": 0.5},
    "gravity_pd": {"kp": 3.0, "kd": 1.0},
    "quasi_static_linearisation": {"bandwidth": 3.0, "motor_bandwidth": 5.0},
    "state_feedback": {"motor_position": 3.0, "motor_speed": 1.0, "link_position": 1.0, "link_speed": 0.5},
}
"""Settings with which the laws below are tried; a new law without an entry fails here."""


@pytest.fixture(params=sorted(control_laws()))
def law(request: pytest.FixtureRequest) -> AbstractControlLaw:
    """Return each control law in turn."""
    return control_law({"kind": request.param, **SETTINGS[request.param]})


def test_pid_is_found_by_its_name() -> None:
    assert control_laws()["pid"] is Pid


@pytest.mark.parametrize("n_motors", [1, 3])
def test_function_has_the_shapes_of_the_contract(law: AbstractControlLaw, n_motors: int) -> None:
    context = loop_of(law, n_motors, 1e-3)
    update = law.function(context)
    per_motor = 8 if law.follows_link_motion else 3
    measured = context.measurements.size
    sizes = [law.state_size(context), per_motor * n_motors, measured, len(law.gain_names(context))]
    assert [update.numel_in(i) for i in range(4)] == sizes
    assert [update.numel_out(i) for i in range(2)] == [n_motors, law.state_size(context)]
    assert law.gains(context).shape == (sizes[3],)
    assert law.initial_state(context).shape == (sizes[0],)


def test_every_setting_is_described(law: AbstractControlLaw) -> None:
    for name, field in type(law).model_fields.items():
        assert "[" in (field.description or ""), f"{law.kind}.{name} lacks a description with its unit"


def test_commands_stay_within_the_robot_limits(law: AbstractControlLaw) -> None:
    context = loop_of(law, 2, 1e-3, [5.0, np.inf])
    update, gains = law.function(context), law.gains(context)
    reference = np.zeros(context.references.size)
    wanted = {"motor_position": 9.0, "link_position": 9.0, "feedforward_torque": 50.0}
    for name, value in wanted.items():
        if name in context.references.sizes:
            reference[context.references.rows(name)] = value
    measured = np.zeros(context.measurements.size)
    command = np.asarray(update(law.initial_state(context), reference, measured, gains)[0]).ravel()
    assert command[0] == 5.0
    assert command[1] > 5.0


def test_unknown_kind_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"unknown kind 'pidd' in controller: did you mean 'pid'\? allowed are .*pid"):
        control_law({"kind": "pidd"})


def test_unknown_setting_offers_the_nearest() -> None:
    with pytest.raises(InputError, match=r"unknown key 'kpp': did you mean 'kp'\?"):
        control_law({"kind": "pid", "kp": 1.0, "kpp": 1.0})
