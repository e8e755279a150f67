"""The cascade against its equations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.control.cascade import Cascade
from tests.control.loop_contexts import loop_context

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

T = 5e-4


def run(law: Cascade, references: FloatArray, positions: FloatArray) -> FloatArray:
    context = loop_context(1, T)
    update, gains, memory = law.function(context), law.gains(context), law.initial_state(context)
    commands = []
    for reference, position in zip(references, positions, strict=True):
        command, memory = (np.asarray(out).ravel() for out in update(memory, reference, position, gains))
        commands.append(command[0])
    return np.array(commands)


def test_equations_hold_sample_by_sample() -> None:
    rng = np.random.default_rng(2)
    references, positions = rng.normal(size=(30, 3)), rng.normal(size=(30, 1))
    law = Cascade(position_gain=20.0, speed_gain=3.0, integral_gain=40.0, speed_filter=1e-3)
    speed, integral, before, expected = 0.0, 0.0, positions[0, 0], []
    for (target, target_speed, feedforward), position in zip(references, positions[:, 0], strict=True):
        speed = (1e-3 * speed + position - before) / (1e-3 + T)
        error = target_speed + 20.0 * (target - position) - speed
        integral += T * 40.0 * error
        expected.append(feedforward + 3.0 * error + integral)
        before = position
    np.testing.assert_allclose(run(law, references, positions), expected, rtol=1e-11)


def test_constant_speed_is_followed_without_position_error_torque() -> None:
    time = np.arange(50) * T
    references = np.column_stack([2.0 * time, np.full(50, 2.0), np.zeros(50)])
    commands = run(Cascade(position_gain=20.0, speed_gain=3.0), references, 2.0 * time[:, None])
    np.testing.assert_allclose(commands[1:], 0.0, atol=1e-9)
    assert commands[0] == 6.0  # the speed is not known before the second sample
