"""The compiled controller against the law, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import AbstractControlLaw, control_law
from flexros.control.controller import Controller
from flexros.control.pid import Pid
from flexros.errors import InputError, RunError
from tests.control.loop_contexts import loop_context

T = 5e-4
ONE, TWO = loop_context(1, T), loop_context(2, T)
LIMITED = loop_context(2, T, [20.0, 30.0])
LAWS = [
    control_law({"kind": "pid", "kp": [10.0, 20.0], "ki": 500.0, "kd": 0.1, "derivative_filter": 1e-3}),
    control_law({"kind": "cascade", "position_gain": 5.0, "speed_gain": 1.0, "integral_gain": 300.0}),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_steps_equal_the_law_in_the_virtual_machine(law: AbstractControlLaw) -> None:
    rng = np.random.default_rng(3)
    controller, update = Controller(law, LIMITED), law.function(LIMITED)
    memory = law.initial_state(LIMITED)
    for _ in range(200):
        reference, position = rng.normal(size=6), rng.normal(size=2)
        expected, memory = (np.asarray(out).ravel() for out in update(memory, reference, position, controller.gains))
        assert np.array_equal(controller.step(position, reference), expected)
    assert np.array_equal(controller.state, memory)


def test_reset_repeats_the_run() -> None:
    controller = Controller(LAWS[0], TWO)
    first = [controller.step([0.1, 0.2], [1.0, 1.0, 0, 0, 0, 0]) for _ in range(3)]
    controller.reset()
    assert np.array_equal([controller.step([0.1, 0.2], [1.0, 1.0, 0, 0, 0, 0]) for _ in range(3)], first)


def test_commands_of_earlier_samples_are_kept() -> None:
    controller = Controller(Pid(kp=1.0), ONE)
    first = controller.step([0.0], [1.0, 0.0, 0.0])
    controller.step([0.0], [2.0, 0.0, 0.0])
    assert first.tolist() == [1.0]


def test_gains_change_from_the_next_sample_on() -> None:
    controller = Controller(Pid(kp=1.0), ONE)
    controller.gains = Pid(kp=5.0).gains(ONE)
    assert controller.step([0.0], [1.0, 0.0, 0.0])[0] == 5.0


def test_wrong_gains_are_refused_with_their_names() -> None:
    controller = Controller(Pid(kp=1.0), ONE)
    with pytest.raises(InputError, match=r"allowed are 5 numbers \(motor_1\.kp, motor_1\.ki"):
        controller.gains = np.zeros(3)


@pytest.mark.parametrize(
    ("position", "reference"), [([0.0], [0.0] * 6), ([0.0] * 2, [0.0] * 5), ([0.0] * 3, [0.0] * 6)]
)
def test_wrong_sizes_are_refused(position: list[float], reference: list[float]) -> None:
    with pytest.raises(RunError, match=r"controller of 2 motors got .* needed are 2 and 6"):
        Controller(LAWS[0], TWO).step(position, reference)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_measurement_that_is_not_finite_is_refused_and_changes_nothing(bad: float) -> None:
    controller = Controller(LAWS[0], LIMITED)
    controller.step([0.0, 0.1], [0.0] * 6)
    before = controller.state
    with pytest.raises(
        RunError, match=r"measured motor_position of motor_2 is (nan|inf|-inf), needed is a finite number"
    ):
        controller.step([0.0, bad], [0.0] * 6)
    assert np.array_equal(controller.state, before)


def test_reference_that_is_not_finite_names_its_motor() -> None:
    with pytest.raises(RunError, match="the reference motor_velocity of motor_1 is nan"):
        Controller(LAWS[0], TWO).step([0.0, 0.0], [0.0, 0.0, np.nan, 0.0, 0.0, 0.0])


def test_overflowing_command_is_refused() -> None:
    with pytest.raises(RunError, match="the loop has diverged"):
        Controller(Pid(kp=1e308), ONE).step([0.0], [1e10, 0.0, 0.0])
