"""Signals of a loop by name."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.control.context import LoopContext, SignalLayout
from flexros.errors import InputError
from tests.control.loop_contexts import loop_context

LAYOUT = SignalLayout({"motor_position": 2, "tool_acceleration": 3})


def test_signals_of_a_loop_are_those_of_its_robot() -> None:
    context = loop_context(3, 1e-3)
    assert dict(context.measurements.sizes) == {"motor_position": 3}
    assert dict(context.references.sizes) == {"motor_position": 3, "motor_velocity": 3, "feedforward_torque": 3}
    assert (context.n_motors, context.measurements.size, context.references.size) == (3, 3, 9)


def test_part_is_cut_from_samples_and_symbols_alike() -> None:
    assert LAYOUT.part(np.arange(10.0).reshape(2, 5), "tool_acceleration").tolist() == [[2, 3, 4], [7, 8, 9]]
    assert str(LAYOUT.part(casadi.SX.sym("y", LAYOUT.size), "tool_acceleration")) == "[y_2, y_3, y_4]"


def test_stack_is_the_inverse_of_part() -> None:
    samples = np.arange(10.0).reshape(2, 5)
    assert np.array_equal(LAYOUT.stack({name: LAYOUT.part(samples, name) for name in LAYOUT.sizes}), samples)


def test_row_belongs_to_an_element_of_a_signal() -> None:
    assert [LAYOUT.element(row) for row in (0, 1, 2, 4)] == [
        ("motor_position", 0),
        ("motor_position", 1),
        ("tool_acceleration", 0),
        ("tool_acceleration", 2),
    ]
    with pytest.raises(IndexError):
        LAYOUT.element(5)


def test_signal_that_the_loop_lacks_is_refused_with_those_it_has() -> None:
    with pytest.raises(InputError, match=r"'link_position'.*motor_position, tool_acceleration"):
        LAYOUT.rows("link_position")


@pytest.mark.parametrize("sample_time", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_sample_time_is_refused(sample_time: float) -> None:
    with pytest.raises(InputError, match=r"sample time of the controller is .* must be positive"):
        LoopContext(loop_context(1, 1e-3).robot, sample_time)
