"""The linear law in state space against its equations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from pydantic import ValidationError

from flexros.control.base import control_law
from flexros.control.design.fixed_structure import pid_system
from flexros.control.linear_controller import linear_controller
from flexros.control.pid import Pid
from flexros.control.state_space import StateSpace
from flexros.errors import InputError
from tests.control.loop_contexts import loop_context

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw

T = 5e-4


def run(law: AbstractControlLaw, references: FloatArray, positions: FloatArray, limit: float = np.inf) -> FloatArray:
    """Step a law through references (n, 3M) and positions (n, M)."""
    motors = positions.shape[1]
    context = loop_context(motors, T, [limit] * motors)
    update, gains = law.function(context), law.gains(context)
    memory, commands = law.initial_state(context), []
    for reference, position in zip(references, positions, strict=True):
        command, memory = (np.asarray(out).ravel() for out in update(memory, reference, position, gains))
        commands.append(command)
    return np.array(commands)


def law_of(A: object, B: object, C: object, D: object, **settings: object) -> StateSpace:
    return StateSpace.model_validate({"A": A, "B": B, "C": C, "D": D, **settings})


def test_commands_follow_the_matrices() -> None:
    rng = np.random.default_rng(1)
    A, B, C, D = (
        0.3 * rng.normal(size=(3, 3)),
        rng.normal(size=(3, 2)),
        rng.normal(size=(2, 3)),
        rng.normal(size=(2, 2)),
    )
    references, positions = rng.normal(size=(40, 6)), rng.normal(size=(40, 2))
    x, expected = np.zeros(3), []
    for reference, position in zip(references, positions, strict=True):
        e = reference[:2] - position
        expected.append(reference[4:] + C @ x + D @ e)
        x = A @ x + B @ e
    found = run(law_of(A, B, C, D), references, positions)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_pid_as_matrices_equals_the_pid_law() -> None:
    rng = np.random.default_rng(2)
    references, positions = np.zeros((200, 3)), np.vstack([np.zeros(1), rng.normal(scale=1e-3, size=(199, 1))])
    gains = {"kp": 24.0, "ki": 100.0, "kd": 2.35, "derivative_filter": 2.6e-3}
    system = pid_system(**gains, sample_time=T)
    found = run(law_of(system.A, system.B, system.C, system.D), references, positions)
    np.testing.assert_allclose(found, run(Pid(**gains), references, positions), rtol=0, atol=1e-11)


def test_inputs_choose_measurement_reference_or_their_difference() -> None:
    empty = {"A": [], "B": [], "C": [[]]}
    references, positions = np.array([[5.0, 7.0, 0.0]]), np.array([[2.0]])
    for inputs, gain, expected in (
        (("motor_position_error",), [[1.0]], 3.0),
        (("motor_position",), [[-1.0]], -2.0),
        (("motor_velocity_reference", "motor_position"), [[1.0, 10.0]], 27.0),
    ):
        assert run(law_of(**empty, D=gain, inputs=inputs), references, positions)[0, 0] == expected


def test_long_saturation_does_not_wind_up() -> None:
    system = pid_system(24.0, 500.0, 2.35, 2.6e-3, T)
    positions = np.vstack([np.full((4000, 1), -0.5), np.full((400, 1), 0.02)])
    references = np.zeros((len(positions), 3))
    law = law_of(system.A, system.B, system.C, system.D)
    without = law_of(system.A, system.B, system.C, system.D, anti_windup=[[0.0], [0.0]])
    held, wound = (run(one, references, positions, 5.0)[4100:, 0] for one in (law, without))
    assert np.all(wound == 5.0)
    assert np.max(np.abs(held)) < 4.5


def test_feedforward_that_alone_reaches_the_limit_leaves_the_state_alone() -> None:
    law = law_of([[1.0]], [[1.0]], [[1.0]], [[2.0]], anti_windup=[[0.5]])
    references = np.array([[0.0, 0.0, 50.0]] * 100 + [[0.0, 0.0, 0.0]])
    assert run(law, references, np.zeros((101, 1)), 5.0)[-1, 0] == 0.0


def test_matrices_of_one_motor_hold_for_each_motor() -> None:
    rng = np.random.default_rng(3)
    A, B, C, D = (
        0.3 * rng.normal(size=(2, 2)),
        rng.normal(size=(2, 2)),
        rng.normal(size=(1, 2)),
        rng.normal(size=(1, 2)),
    )
    law = law_of(A, B, C, D, inputs=("motor_position_error", "motor_velocity_reference"))
    references, positions = rng.normal(size=(20, 9)), rng.normal(size=(20, 3))
    together = run(law, references, positions)
    for motor in range(3):
        alone = run(law, references[:, motor::3], positions[:, motor : motor + 1])
        np.testing.assert_allclose(together[:, motor], alone[:, 0], rtol=1e-12, atol=1e-12)


def test_linear_controller_returns_the_matrices() -> None:
    law = law_of([[0.5]], [[1.0]], [[3.0]], [[2.0]])
    linear = linear_controller(law, loop_context(1, T))
    assert (linear.state_step, linear.from_state, linear.from_measured) == (0.5, 3.0, -2.0)


@pytest.mark.parametrize("ending", ["npz", "mat", "json", "yaml"])
def test_matrices_from_a_file(tmp_path: Path, ending: str) -> None:
    file = tmp_path / f"k.{ending}"
    matrices = {"A": [[0.5]], "B": [[1.0]], "C": [[3.0]], "D": [[2.0]], "dt": T}
    if ending == "npz":
        np.savez(file, **matrices)
    elif ending == "mat":
        from scipy.io import savemat

        savemat(file, matrices)
    else:
        import json

        file.write_text(json.dumps(matrices))
    law = control_law({"kind": "state_space", "file": str(file)})
    assert law == law_of([[0.5]], [[1.0]], [[3.0]], [[2.0]], matrices_sample_time=T)


def test_settings_build_the_same_law_again() -> None:
    law = law_of([[0.5]], [[1.0]], [[3.0]], [[2.0]], anti_windup=[[0.1]])
    assert control_law({"kind": "state_space", **law.model_dump(mode="json")}) == law


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"B": [[1.0], [2.0]]}, "B has 2 rows"),
        ({"D": []}, "D is empty"),
        ({"anti_windup": [[1.0, 2.0]]}, "anti_windup"),
    ],
)
def test_sizes_that_do_not_fit_are_refused(change: dict[str, object], named: str) -> None:
    with pytest.raises(ValidationError, match=named):
        law_of(**{"A": [[0.5]], "B": [[1.0]], "C": [[3.0]], "D": [[2.0]], **change})


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"inputs": ("motor_positon",)}, "motor_position"),
        ({"matrices_sample_time": 1e-3}, "0.001 s"),
        ({"D": [[2.0, 1.0]], "B": [[1.0, 1.0]]}, "1 motors"),
        ({"D": [[2.0], [1.0]], "C": [[1.0], [1.0]]}, "1 motors"),
    ],
)
def test_matrices_that_do_not_fit_the_loop_are_refused(settings: dict[str, object], named: str) -> None:
    law = law_of(**{"A": [[0.5]], "B": [[1.0]], "C": [[3.0]], "D": [[2.0]], **settings})
    with pytest.raises(InputError, match=named):
        law.gains(loop_context(1, T))
