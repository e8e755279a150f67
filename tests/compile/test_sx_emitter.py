from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.compile import compile_function, machine_code, sx_emitter

OPERATIONS = (
    lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b, lambda a, b: a / (1.5 + b * b), lambda a, b: ca.sin(a),
    lambda a, b: ca.cos(b), lambda a, b: ca.tanh(a), lambda a, b: ca.exp(-a * a), lambda a, b: ca.atan2(a, b),
    lambda a, b: ca.if_else(a < b, a, b * b), lambda a, b: ca.fmax(a, b), lambda a, b: ca.fabs(a), lambda a, b: -a,
    lambda a, b: ca.sqrt(1 + a * a), lambda a, b: ca.log(1 + b * b), lambda a, b: ca.sign(a) * b,
    lambda a, b: ca.logic_and(a > 0, b > 0) + a, lambda a, b: ca.fmod(a, 1 + b * b), lambda a, b: ca.floor(a) * 0.5,
)  # fmt: skip


def random_function(seed: int, length: int) -> ca.Function:
    """A function of two inputs and two outputs over all kinds of operations."""
    rng = np.random.default_rng(seed)
    x, y = ca.SX.sym("x", 4), ca.SX.sym("y", 2, 2)
    values = [*ca.vertsplit(x), *ca.vertsplit(ca.vec(y)), ca.SX(0.25)]
    for _ in range(length):
        a, b = rng.integers(max(0, len(values) - 40), len(values), 2)
        values.append(ca.fmin(10, ca.fmax(-10, OPERATIONS[rng.integers(len(OPERATIONS))](values[a], values[b]))))
    return ca.Function("random", [x, y], [ca.vertcat(*values[-6:]), ca.reshape(ca.vertcat(*values[-9:-5]), 2, 2)])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_function_equals_the_virtual_machine(seed: int) -> None:
    function = random_function(seed, 150)
    rng = np.random.default_rng(seed + 1000)
    x, y = rng.normal(size=4), rng.normal(size=(2, 2))
    for actual, expected in zip(compile_function(function)(x, y), function(x, y), strict=True):
        np.testing.assert_allclose(actual.reshape(expected.shape), expected.full(), rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [2, 4, 8, 16])
def test_lanes_give_the_same_bits_as_one_evaluation_after_another(lanes: int) -> None:
    function = random_function(7, 300)
    single = compile_function(function)
    rng = np.random.default_rng(lanes)
    x, y = rng.normal(size=(4, lanes)), rng.normal(size=(4, lanes))
    actual = compile_function(function, lanes=lanes)(x, y)
    for lane in range(lanes):
        expected = single(x[:, lane], y[:, lane].reshape(2, 2, order="F"))
        for k in range(2):
            np.testing.assert_array_equal(actual[k][:, lane], expected[k].ravel(order="F"))


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [1, 8])
def test_cutting_into_parts_changes_no_bit(monkeypatch: pytest.MonkeyPatch, lanes: int) -> None:
    function = random_function(11, 400)
    inputs = [
        np.random.default_rng(5).normal(size=shape) for shape in compile_function(function, lanes=lanes).input_shapes
    ]
    whole = compile_function(function, lanes=lanes)(*inputs)
    monkeypatch.setattr(sx_emitter, "PART_LENGTH", 60)
    parts = compile_function(function, lanes=lanes)(*inputs)
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_array_equal(one, other)


def test_gathering_sines_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    function = random_function(13, 200)
    inputs = np.array([0.1, 0.2, 0.3, 0.4]), np.ones((2, 2))
    gathered = compile_function(function)(*inputs)
    monkeypatch.setattr(sx_emitter, "GROUP_SIZE", 1)
    for one, other in zip(gathered, compile_function(function)(*inputs), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("lanes", [1, 8])
def test_results_do_not_depend_on_the_processor(monkeypatch: pytest.MonkeyPatch, lanes: int) -> None:
    """The plainest processor of the architecture has neither wide vectors nor fused multiply-add."""
    function = random_function(17, 200)
    native = compile_function(function, lanes=lanes)
    inputs = [np.random.default_rng(6).normal(size=shape) for shape in native.input_shapes]
    monkeypatch.setattr(machine_code, "_host", lambda: ("generic", ""))
    plain = compile_function(function, lanes=lanes)
    for one, other in zip(native(*inputs), plain(*inputs), strict=True):
        np.testing.assert_array_equal(one, other)


def test_outputs_that_are_inputs_or_constants_are_copied() -> None:
    x = ca.SX.sym("x", 2)
    compiled = compile_function(ca.Function("f", [x], [ca.vertcat(x[1], 3, x[1])]))
    assert compiled([1.0, 2.0])[0].tolist() == [2.0, 3.0, 2.0]
