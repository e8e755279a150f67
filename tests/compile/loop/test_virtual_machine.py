from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from flexros.compile import LoopFunctions, LoopInputs, LoopResult, compile_loop, machine_code
from flexros.compile.loop.machine_code import MachineCodeLoop
from flexros.compile.loop.virtual_machine import VirtualMachineLoop
from flexros.robot import load_robot
from tests.compile.conftest import GAINS, PARAMETERS, SAMPLE_TIME, STATE, reference, rich_inputs, unstable

pytestmark = pytest.mark.slow

TIMINGS = [
    {"delay": 0.0, "substeps": 1},
    {"delay": 0.3 * SAMPLE_TIME, "substeps": 2},
    {"delay": SAMPLE_TIME, "substeps": 1},
    {"delay": 3.6 * SAMPLE_TIME, "substeps": 3},
]


def both(
    functions: LoopFunctions, samples: int, inputs: LoopInputs, **timing: float | tuple[float, ...]
) -> list[LoopResult]:
    results = []
    for engine in ("machine_code", "virtual_machine"):
        kernel = compile_loop(functions, sample_time=SAMPLE_TIME, engine=engine, **timing)
        start = STATE if kernel.sizes.state == len(STATE) else np.full(kernel.sizes.state, 0.9)
        results.append(kernel.run(kernel.initial_state(start), samples, inputs, record_states=True))
    return results


def assert_equal(results: list[LoopResult]) -> None:
    compiled, interpreted = results
    for name in ("encoder", "command", "tool_pose", "states"):
        scale = np.nanmax(np.abs(getattr(interpreted, name)))
        np.testing.assert_allclose(getattr(compiled, name), getattr(interpreted, name), rtol=0, atol=1e-12 * scale)
    for name in ("plant", "controller", "line"):
        one, other = getattr(compiled.final, name), getattr(interpreted.final, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * (1 + np.abs(other).max(initial=0)))
    np.testing.assert_array_equal(compiled.diverged, interpreted.diverged)


@pytest.mark.parametrize("timing", TIMINGS)
@pytest.mark.parametrize("limit", [0, 10_000])
def test_machine_code_equals_the_virtual_machine(
    chain: LoopFunctions, timing: dict[str, float], limit: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flexros.compile.loop.runge_kutta.MERGED_INSTRUCTIONS", limit)
    assert_equal(both(chain, 250, rich_inputs(250), **timing))


def test_lanes_with_own_parameters_equal_the_virtual_machine(chain: LoopFunctions) -> None:
    scale = np.array([1.0, 1.1, 0.9, 1.3])
    inputs = replace(rich_inputs(50), parameters=np.outer(PARAMETERS, scale), gains=np.outer(GAINS, scale))
    assert_equal(both(chain, 50, inputs, lanes=4))


def test_sensor_and_exact_update_equal_the_virtual_machine(chain: LoopFunctions) -> None:
    y, x, u, w, p, h = (ca.SX.sym("s", size) for size in (2, 10, 2, 6, 2, 1))
    functions = replace(
        chain,
        sensor=ca.Function("sensor", [y, x, p], [y + 1e-3 * ca.sin(40 * x[3:5])]),
        exact_update=ca.Function("exact", [x, u, w, p, h], [ca.vertcat(x[:8], x[8:] * ca.exp(-3 * h))]),
    )
    assert_equal(both(functions, 100, rich_inputs(100), substeps=2))


def test_updates_before_and_after_a_step_equal_the_virtual_machine(chain: LoopFunctions) -> None:
    x, u, w, p, h = (ca.SX.sym("s", size) for size in (10, 2, 6, 2, 1))
    functions = replace(
        chain,
        before_step=ca.Function("before", [x, u, w, p, h], [ca.vertcat(x[:8], x[8:] + h * u)]),
        after_step=ca.Function("after", [x, u, w, p, h], [ca.vertcat(x[:8], x[8:] * ca.exp(-3 * h))]),
    )
    assert_equal(both(functions, 100, rich_inputs(100), substeps=2, delay=1.3 * SAMPLE_TIME))


def test_another_step_equals_the_virtual_machine(chain: LoopFunctions) -> None:
    rates = chain.derivative
    x, u, w, p = (ca.SX.sym(name, rates.numel_in(k)) for k, name in enumerate("xuwp"))
    weights = ca.SX.sym("weights", 3)
    euler = ca.Function("euler", [x, u, w, p, weights], [x + weights[0] * rates(x, u, w, p)])
    results = both(replace(chain, step=euler), 50, rich_inputs(50), substeps=2)
    assert_equal(results)
    assert not np.allclose(results[0].encoder, both(chain, 50, rich_inputs(50), substeps=2)[0].encoder, rtol=1e-9)


@pytest.mark.parametrize("lanes", [1, 4])
def test_delays_of_single_motors_equal_the_virtual_machine(chain: LoopFunctions, lanes: int) -> None:
    delay = (0.4 * SAMPLE_TIME, 2.0 * SAMPLE_TIME)
    assert_equal(both(chain, 60, rich_inputs(60), lanes=lanes, delay=delay))


def test_robot_equals_the_virtual_machine(chain: LoopFunctions) -> None:
    model = load_robot("e12").model
    loop = LoopFunctions(model.derivative, model.encoder, model.tool_pose, chain.controller)
    inputs = LoopInputs(reference=reference(200), gains=np.array([135000.0, 9000.0, 0.0]))
    assert_equal(both(loop, 200, inputs))


@pytest.mark.parametrize("samples", [1, 199, 200, 201])
def test_length_of_the_run_does_not_matter(chain: LoopFunctions, samples: int) -> None:
    assert_equal(both(chain, samples, rich_inputs(samples)))


@pytest.mark.parametrize("p", [300.0, 7e4])
def test_divergence_is_found_at_the_same_sample(p: float) -> None:
    inputs = LoopInputs(reference=np.zeros((1, 1)), parameters=np.array([p]))
    compiled, interpreted = both(unstable(), 450, inputs)
    assert compiled.diverged == interpreted.diverged
    assert compiled.diverged > 0
    np.testing.assert_array_equal(np.isnan(compiled.encoder), np.isnan(interpreted.encoder))


def test_stepping_equals_the_run(chain: LoopFunctions) -> None:
    kernel = compile_loop(chain, sample_time=SAMPLE_TIME, delay=1.4 * SAMPLE_TIME, engine="virtual_machine")
    inputs = LoopInputs(reference=reference(20), parameters=PARAMETERS, gains=GAINS)
    whole = kernel.run(kernel.initial_state(STATE), 20, inputs)
    step = kernel.stepper(kernel.initial_state(STATE), PARAMETERS)
    for k in range(20):
        step.measure()
        np.testing.assert_array_equal(step.encoder, whole.encoder[k])
        np.testing.assert_array_equal(step.tool_pose, whole.tool_pose[k])
        step.command[:] = whole.command[k]
        step.advance()
    np.testing.assert_array_equal(step.plant, whole.final.plant)


def test_virtual_machine_is_taken_where_llvmlite_is_missing(
    chain: LoopFunctions, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert isinstance(compile_loop(chain, sample_time=SAMPLE_TIME).engine, MachineCodeLoop)
    monkeypatch.setattr(machine_code, "find_spec", lambda name: None)
    assert isinstance(compile_loop(chain, sample_time=SAMPLE_TIME).engine, VirtualMachineLoop)
