"""The PID law against its equations, one behaviour each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from pydantic import ValidationError

from flexros.control.pid import Pid
from flexros.errors import InputError
from tests.control.loop_contexts import loop_context

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

T = 5e-4


def run(
    law: Pid,
    references: FloatArray,
    positions: FloatArray,
    limits: list[float] | None = None,
    state: FloatArray | None = None,
) -> FloatArray:
    """Step the law with the CasADi virtual machine through references (n, 3M) and positions (n, M)."""
    n_motors = positions.shape[1]
    context = loop_context(n_motors, T, limits)
    update, gains = law.function(context), law.gains(context)
    memory = law.initial_state(context) if state is None else state
    commands = []
    for reference, position in zip(references, positions, strict=True):
        command, memory = (np.asarray(out).ravel() for out in update(memory, reference, position, gains))
        commands.append(command)
    return np.array(commands)


def random_signals(n: int, n_motors: int, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return references (n, 3M) and positions (n, M) of the magnitude of the circle test."""
    rng = np.random.default_rng(seed)
    references = rng.normal(scale=1e-3, size=(n, 3 * n_motors))
    references[:, 2 * n_motors :] *= 1e6
    return references, rng.normal(scale=1e-3, size=(n, n_motors))


def test_published_pd_is_reproduced_to_the_last_bit() -> None:
    references, positions = random_signals(50, 2)
    error = references[:, :2] - positions
    before = np.vstack([error[:1], error[:-1]])
    expected = references[:, 4:] + 135000.0 * error + 9000.0 * ((error - before) / T)
    assert np.array_equal(run(Pid(kp=135000.0, kd=9000.0), references, positions), expected)


def test_first_sample_away_from_the_reference_has_no_derivative_kick() -> None:
    references = np.array([[0.1, 0.0, 0.0]])
    command = run(Pid(kp=10.0, kd=1000.0), references, np.zeros((1, 1)))
    assert command[0, 0] == 1.0


def test_reference_velocity_is_not_used() -> None:
    references, positions = random_signals(5, 1)
    changed = references.copy()
    changed[:, 1] += 7.0
    law = Pid(kp=10.0, ki=3.0, kd=2.0)
    assert np.array_equal(run(law, references, positions), run(law, changed, positions))


def test_derivative_filter_decays_with_its_time_constant() -> None:
    tau = 0.01
    references = np.zeros((201, 3))
    references[1:, 0] = 1.0
    commands = run(Pid(kp=0.0, kd=1.0, derivative_filter=tau), references, np.zeros((201, 1)))[1:, 0]
    expected = (tau / (tau + T)) ** np.arange(200) / (tau + T)
    np.testing.assert_allclose(commands, expected, rtol=1e-12)
    np.testing.assert_allclose(np.sum(commands) * T, 1.0, rtol=1e-4)


def test_integral_sums_the_error_from_the_first_sample_on() -> None:
    references = np.zeros((4, 3))
    references[:, 0] = 2.0
    commands = run(Pid(kp=0.0, ki=10.0), references, np.zeros((4, 1)))
    np.testing.assert_allclose(commands[:, 0], 20.0 * T * np.arange(1, 5), rtol=1e-14)


def test_feedforward_is_added_before_the_limit() -> None:
    references = np.array([[1.0, 0.0, 15.0], [1.0, 0.0, -25.0]])
    commands = run(Pid(kp=10.0), references, np.zeros((2, 1)), limits=[20.0])
    assert commands.ravel().tolist() == [20.0, -15.0]


def test_lower_limit_of_setting_and_robot_holds() -> None:
    assert Pid(kp=1.0, torque_limit=5.0).gains(loop_context(2, T, [3.0, 20.0]))[-2:].tolist() == [3.0, 5.0]


def test_integral_does_not_wind_up_at_the_limit() -> None:
    n = 2000
    references = np.zeros((2 * n, 3))
    references[:n, 0] = 10.0
    references[n:, 0] = -0.01
    commands = run(Pid(kp=10.0, ki=100.0), references, np.zeros((2 * n, 1)), limits=[20.0])
    assert np.all(commands[:n] == 20.0)
    assert commands[n, 0] < 0.0  # with 1000 Nm wound up the command would stay at +20 Nm for 1000 s


def test_integral_unwinds_while_the_feedforward_holds_the_limit() -> None:
    references = np.tile([[-1.0, 0.0, 50.0]], (10, 1))
    references[-1, 2] = 0.0
    commands = run(Pid(kp=0.0, ki=100.0), references, np.zeros((10, 1)), limits=[20.0])
    assert np.all(commands[:-1] == 20.0)
    np.testing.assert_allclose(commands[-1, 0], -100.0 * 10 * T, rtol=1e-12)


def test_gains_change_while_running_without_a_step_from_memory() -> None:
    law = Pid(kp=0.0, ki=10.0)
    context = loop_context(1, T)
    update, state = law.function(context), law.initial_state(context)
    reference, position = np.array([1.0, 0.0, 0.0]), np.zeros(1)
    for _ in range(10):
        before, state = (np.asarray(out).ravel() for out in update(state, reference, position, law.gains(context)))
    after, _ = update(state, reference, position, Pid(kp=0.0, ki=0.0).gains(context))
    assert float(after) == before[0]


def test_motors_do_not_influence_each_other() -> None:
    references, positions = random_signals(20, 3)
    law = Pid(kp=(1.0, 2.0, 3.0), ki=(4.0, 5.0, 6.0), kd=(7.0, 8.0, 9.0), derivative_filter=(0.0, 1e-3, 2e-3))
    alone = Pid(kp=2.0, ki=5.0, kd=8.0, derivative_filter=1e-3)
    expected = run(alone, references[:, 1::3], positions[:, 1:2])
    assert np.array_equal(run(law, references, positions)[:, 1:2], expected)


def test_gain_names_match_the_gain_vector() -> None:
    law = Pid(kp=(1.0, 2.0), kd=3.0)
    context = loop_context(2, T)
    named = dict(zip(law.gain_names(context), law.gains(context), strict=True))
    assert (named["motor_2.kp"], named["motor_1.kd"], named["motor_2.torque_limit"]) == (2.0, 3.0, np.inf)


def test_wrong_number_of_gains_is_named() -> None:
    with pytest.raises(
        InputError, match=r"controller\.kp has 3 values, allowed is one, or one for each of the 2 motors"
    ):
        Pid(kp=(1.0, 2.0, 3.0)).gains(loop_context(2, T))


@pytest.mark.parametrize("kp", [-1.0, float("nan"), float("inf")])
def test_impossible_gains_are_refused(kp: float) -> None:
    with pytest.raises(ValidationError):
        Pid(kp=kp)
