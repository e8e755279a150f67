"""The command that acts behind the delay of a robot."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.control.context import LoopContext
from flexros.control.model.command_line import CommandLine
from flexros.robot import load_robot


@pytest.mark.parametrize(
    ("delay", "size", "wanted"), [(0.0, 0, 4.0), (1e-3, 2, 2.0), (7.5e-4, 2, 2.5), (2.5e-4, 1, 3.5)]
)
def test_mean_command_of_the_next_sample(delay: float, size: int, wanted: float) -> None:
    robot = load_robot("four_mass_linear").with_values({"delay": delay})
    line = CommandLine(LoopContext(robot, 5e-4))
    assert line.size == size
    past, command = casadi.SX.sym("past", size), casadi.SX.sym("u")
    step = casadi.Function("step", [past, command], [line.acting(past, command), line.after(past, command)])
    state = np.zeros(size)
    for value in (1.0, 2.0, 3.0, 4.0):
        acting, after = step(state, value)
        state = after.full().ravel()
    assert float(acting) == pytest.approx(wanted)


def test_before_the_first_sample_the_holding_command_acts() -> None:
    robot = load_robot("four_mass_linear").with_values({"delay": 1e-3})
    line, past = CommandLine(LoopContext(robot, 5e-4)), casadi.SX.sym("past", 2)
    started, held = casadi.SX.sym("started"), casadi.SX.sym("held")
    begun = casadi.Function("begun", [past, started, held], [line.begun(past, started, held)])
    assert begun([1.0, 2.0], 0, 7.0).full().ravel().tolist() == [7.0, 7.0]
    assert begun([1.0, 2.0], 1, 7.0).full().ravel().tolist() == [1.0, 2.0]
