from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.compile import LoopFunctions, LoopInputs, LoopKernel, LoopState, compile_loop
from flexros.compile.loop import kernel as kernel_module
from flexros.errors import InputError
from tests.compile.conftest import GAINS, PARAMETERS, SAMPLE_TIME, STATE, integrator, rich_inputs

pytestmark = pytest.mark.slow


def open_loop(functions: LoopFunctions) -> LoopFunctions:
    """The command is the reference torque, whatever is measured."""
    c, r, y, g = ca.SX.sym("c", 0), ca.SX.sym("r", 2), ca.SX.sym("y", 2), ca.SX.sym("g", 0)
    return replace(functions, controller=ca.Function("controller", [c, r, y, g], [r, c]))


@pytest.fixture(scope="module")
def kernel(chain: LoopFunctions) -> LoopKernel:
    return compile_loop(chain, sample_time=SAMPLE_TIME, delay=0.7 * SAMPLE_TIME, substeps=2)


def test_plant_follows_dop853(chain: LoopFunctions) -> None:
    kernel = compile_loop(open_loop(chain), sample_time=SAMPLE_TIME)
    samples = 400
    torque = np.array([[30.0, 20.0]])
    result = kernel.run(
        kernel.initial_state(STATE), samples, LoopInputs(reference=torque, parameters=PARAMETERS), record_states=True
    )
    exact = solve_ivp(
        lambda t, x: chain.derivative(x, torque[0], np.zeros(6), PARAMETERS).full().ravel(),
        (0, samples * SAMPLE_TIME), STATE, method="DOP853", rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    np.testing.assert_allclose(result.final.plant, exact.y[:, -1], rtol=0, atol=2e-7)


@pytest.mark.parametrize("limit", [0, 10_000])
def test_integration_is_of_fourth_order(chain: LoopFunctions, limit: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.compile.loop.runge_kutta.MERGED_INSTRUCTIONS", limit)
    finals = []
    for substeps in (1, 2, 4, 64):
        kernel = compile_loop(open_loop(chain), sample_time=4e-3, substeps=substeps)
        inputs = LoopInputs(reference=np.array([[30.0, 20.0]]), parameters=PARAMETERS)
        finals.append(kernel.run(kernel.initial_state(STATE), 25, inputs).final.plant)
    errors = [np.abs(final - finals[-1]).max() for final in finals[:-1]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.7)
    assert np.all(orders < 4.6)


def test_run_in_two_parts_equals_one_run(kernel: LoopKernel) -> None:
    inputs = rich_inputs(100)
    whole = kernel.run(kernel.initial_state(STATE), 100, inputs)
    cut = {name: getattr(inputs, name) for name in ("reference", "noise", "disturbance")}
    first = kernel.run(kernel.initial_state(STATE), 37, replace(inputs, **{k: v[:37] for k, v in cut.items()}))
    second = kernel.run(first.final, 63, replace(inputs, **{k: v[37:] for k, v in cut.items()}))
    np.testing.assert_array_equal(np.vstack([first.encoder, second.encoder]), whole.encoder)
    np.testing.assert_array_equal(second.final.plant, whole.final.plant)
    np.testing.assert_array_equal(second.final.line, whole.final.line)


def test_slices_of_a_long_run_change_nothing(kernel: LoopKernel, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = kernel.run(kernel.initial_state(STATE), 100, rich_inputs(100))
    monkeypatch.setattr(kernel_module, "_SLICE_WORK", 300)
    seen: list[int] = []
    sliced = kernel.run(kernel.initial_state(STATE), 100, rich_inputs(100), progress=seen.append)
    assert seen == [30, 60, 90, 100]
    np.testing.assert_array_equal(sliced.command, whole.command)
    np.testing.assert_array_equal(sliced.final.controller, whole.final.controller)


def test_progress_may_break_off_a_run(kernel: LoopKernel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_module, "_SLICE_WORK", 300)

    def interrupt(done: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        kernel.run(kernel.initial_state(STATE), 100, rich_inputs(100), progress=interrupt)


def test_stepping_sample_by_sample_gives_the_same_bits(chain: LoopFunctions, kernel: LoopKernel) -> None:
    samples = 60
    inputs = rich_inputs(samples)
    whole = kernel.run(kernel.initial_state(STATE), samples, inputs, record_states=True)
    step = kernel.stepper(kernel.initial_state(STATE), PARAMETERS)
    for k in range(samples):
        step.noise[:], step.disturbance[:] = inputs.noise[k], inputs.disturbance[k]
        np.testing.assert_array_equal(step.plant, whole.states[k])
        step.measure()
        np.testing.assert_array_equal(step.encoder, whole.encoder[k])
        np.testing.assert_array_equal(step.tool_pose, whole.tool_pose[k])
        step.command[:] = whole.command[k]
        step.advance()
    np.testing.assert_array_equal(step.plant, whole.final.plant)
    np.testing.assert_array_equal(step.line, whole.final.line)


def test_threads_share_a_kernel(kernel: LoopKernel) -> None:
    inputs = [rich_inputs(50, seed) for seed in range(8)]
    expected = [kernel.run(kernel.initial_state(STATE), 50, one).encoder for one in inputs]
    with ThreadPoolExecutor(4) as pool:
        actual = list(pool.map(lambda one: kernel.run(kernel.initial_state(STATE), 50, one).encoder, inputs))
    np.testing.assert_array_equal(actual, expected)


def test_lanes_are_stepped_together(chain: LoopFunctions) -> None:
    kernel = compile_loop(chain, sample_time=SAMPLE_TIME, lanes=4)
    step = kernel.stepper(kernel.initial_state(STATE), np.outer(PARAMETERS, [1.0, 1.1, 1.2, 1.0]))
    assert step.command.shape == step.encoder.shape == (2, 4)
    for _ in range(3):
        step.measure()
        step.advance()
    np.testing.assert_array_equal(step.plant[:, 0], step.plant[:, 3])
    assert (step.plant[:, 0] != step.plant[:, 1]).any()


@pytest.mark.parametrize("limit", [0, 10_000])
@pytest.mark.parametrize("lanes", [2, 8])
def test_lanes_give_the_same_bits(
    chain: LoopFunctions, lanes: int, limit: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flexros.compile.loop.runge_kutta.MERGED_INSTRUCTIONS", limit)
    timing = {"sample_time": SAMPLE_TIME, "delay": 2.3 * SAMPLE_TIME}
    single, wide = compile_loop(chain, **timing), compile_loop(chain, lanes=lanes, **timing)
    samples = 40
    scale = 1 + 0.1 * np.arange(lanes)
    shared = rich_inputs(samples)
    noise = np.random.default_rng(1).normal(size=(samples, 2, lanes)) * 1e-4
    inputs = replace(shared, noise=noise, parameters=np.outer(PARAMETERS, scale), gains=np.outer(GAINS, scale))
    actual = wide.run(wide.initial_state(STATE), samples, inputs, record_states=True)
    for k in range(lanes):
        one = replace(shared, noise=noise[:, :, k], parameters=PARAMETERS * scale[k], gains=GAINS * scale[k])
        expected = single.run(single.initial_state(STATE), samples, one, record_states=True)
        for name in ("encoder", "command", "tool_pose", "states"):
            np.testing.assert_array_equal(getattr(actual, name)[:, :, k], getattr(expected, name))


@pytest.mark.parametrize(
    ("delay", "expected"),
    [(0.0, [0, 1, 3, 6]), (0.5, [0, 0.5, 2, 4.5]), (1.0, [0, 0, 1, 3]), (2.25, [0, 0, 0, 0.75])],
)
def test_command_acts_after_the_delay(delay: float, expected: list[float]) -> None:
    """x(k) is the integral of the commands 1, 2, 3, ... shifted by the delay; T = 1 s."""
    kernel = compile_loop(integrator(), sample_time=1.0, delay=delay)
    result = kernel.run(kernel.initial_state([0.0]), 4, LoopInputs(reference=np.arange(1.0, 5.0)[:, np.newaxis]))
    np.testing.assert_allclose(result.encoder[:, 0], expected, atol=1e-14)
    assert result.command[:, 0].tolist() == [1, 2, 3, 4]


def test_each_motor_has_its_own_delay() -> None:
    """Two integrators under the commands 1, 2, 3, ..., delayed by 1.5 and 0.25 s; T = 1 s."""
    x, u, w, p = ca.SX.sym("x", 2), ca.SX.sym("u", 2), ca.SX.sym("w", 6), ca.SX.sym("p", 0)
    c, r, y, g = ca.SX.sym("c", 0), ca.SX.sym("r"), ca.SX.sym("y", 2), ca.SX.sym("g", 0)
    functions = LoopFunctions(
        derivative=ca.Function("derivative", [x, u, w, p], [u]),
        encoder=ca.Function("encoder", [x], [x]),
        tool_pose=ca.Function("tool_pose", [x, p], [ca.vertcat(x, 0, 0, 0, 0, 1)]),
        controller=ca.Function("controller", [c, r, y, g], [ca.vertcat(r, r), c]),
    )
    kernel = compile_loop(functions, sample_time=1.0, delay=(1.5, 0.25))
    commands = np.arange(1.0, 6.0)[:, np.newaxis]
    result = kernel.run(kernel.initial_state([0.0, 0.0]), 5, LoopInputs(reference=commands))
    np.testing.assert_allclose(result.encoder[:, 0], [0, 0, 0.5, 2, 4.5], atol=1e-14)
    np.testing.assert_allclose(result.encoder[:, 1], [0, 0.75, 2.5, 5.25, 9], atol=1e-14)


def test_updates_are_called_once_before_and_once_after_every_step() -> None:
    """The state counts: before each step of length h it grows by h, after it is doubled; nothing else moves it."""
    x, u, w, p, h = ca.SX.sym("x"), ca.SX.sym("u"), ca.SX.sym("w", 6), ca.SX.sym("p", 0), ca.SX.sym("h")
    functions = replace(
        integrator(),
        derivative=ca.Function("derivative", [x, u, w, p], [ca.SX(0)]),
        before_step=ca.Function("before", [x, u, w, p, h], [x + h]),
        after_step=ca.Function("after", [x, u, w, p, h], [2 * x]),
    )
    kernel = compile_loop(functions, sample_time=1.0, substeps=2)
    result = kernel.run(kernel.initial_state([0.0]), 2, LoopInputs(reference=np.zeros((1, 1))))
    assert result.encoder[:, 0].tolist() == [0.0, 3.0]


def test_past_commands_stand_newest_first() -> None:
    kernel = compile_loop(integrator(), sample_time=1.0, delay=2.5)
    result = kernel.run(kernel.initial_state([0.0]), 4, LoopInputs(reference=np.arange(1.0, 5.0)[:, np.newaxis]))
    assert result.final.line[:, 0].tolist() == [4, 3, 2]


def test_disturbance_is_held_over_the_sample_and_not_delayed() -> None:
    kernel = compile_loop(integrator(), sample_time=1.0, delay=0.5)
    disturbance = np.zeros((3, 7))
    disturbance[0, 0], disturbance[1, 1] = 2.0, 3.0  # motor torque, then the first component of the wrench
    result = kernel.run(kernel.initial_state([0.0]), 3, LoopInputs(reference=np.zeros((1, 1)), disturbance=disturbance))
    np.testing.assert_allclose(result.encoder[:, 0], [0, 2, 5], atol=1e-14)


def test_noise_is_seen_by_the_encoder_only() -> None:
    kernel = compile_loop(integrator(), sample_time=1.0)
    result = kernel.run(
        kernel.initial_state([1.0]), 2, LoopInputs(reference=np.zeros((1, 1)), noise=np.array([[0.5], [-0.5]]))
    )
    assert result.encoder[:, 0].tolist() == [1.5, 0.5]
    assert result.tool_pose[:, 0].tolist() == [1.0, 1.0]


def test_one_row_holds_for_all_samples(kernel: LoopKernel) -> None:
    row = rich_inputs(1)
    repeated = {name: np.repeat(getattr(row, name), 20, axis=0) for name in ("reference", "noise", "disturbance")}
    held = kernel.run(kernel.initial_state(STATE), 20, row)
    np.testing.assert_array_equal(
        held.command, kernel.run(kernel.initial_state(STATE), 20, replace(row, **repeated)).command
    )


def test_the_given_state_is_not_changed(kernel: LoopKernel) -> None:
    state = kernel.initial_state(STATE.copy(), np.zeros(5))
    kernel.run(state, 10, rich_inputs(10))
    np.testing.assert_array_equal(state.plant, STATE)
    assert not state.controller.any()
    assert not state.line.any()


def test_outputs_that_are_not_wanted_are_absent(kernel: LoopKernel) -> None:
    full = kernel.run(kernel.initial_state(STATE), 10, rich_inputs(10))
    lean = kernel.run(kernel.initial_state(STATE), 10, rich_inputs(10), record_pose=False)
    assert full.states is None
    assert lean.tool_pose is None
    np.testing.assert_array_equal(lean.encoder, full.encoder)


def test_sensor_acts_on_the_noisy_value() -> None:
    y, x, p = ca.SX.sym("y"), ca.SX.sym("x"), ca.SX.sym("p", 0)
    quantised = replace(integrator(), sensor=ca.Function("sensor", [y, x, p], [ca.floor(y / 0.25 + 0.5) * 0.25]))
    kernel = compile_loop(quantised, sample_time=1.0)
    inputs = LoopInputs(reference=np.zeros((1, 1)), noise=np.array([[0.0], [0.1]]))
    result = kernel.run(kernel.initial_state([1.05]), 2, inputs)
    assert result.encoder[:, 0].tolist() == [1.0, 1.25]


def test_splitting_a_stiff_part_off_is_of_second_order() -> None:
    """dx/dt = -a x + z, dz/dt = -x - 500 z, the last term by its exact solution."""
    s, u, w, p, h = ca.SX.sym("s", 2), ca.SX.sym("u"), ca.SX.sym("w", 6), ca.SX.sym("p", 0), ca.SX.sym("h")
    base = integrator()
    functions = replace(
        base,
        derivative=ca.Function("derivative", [s, u, w, p], [ca.vertcat(-s[0] + s[1], -s[0])]),
        exact_update=ca.Function("exact", [s, u, w, p, h], [ca.vertcat(s[0], s[1] * ca.exp(-50 * h))]),
    )
    exact = solve_ivp(
        lambda t, x: [-x[0] + x[1], -x[0] - 50 * x[1]], (0, 0.5), [1.0, 1.0], method="DOP853", rtol=1e-12, atol=1e-14
    ).y[:, -1]
    errors = []
    for substeps in (1, 2, 4):
        kernel = compile_loop(functions, sample_time=0.01, substeps=substeps)
        final = kernel.run(kernel.initial_state([1.0, 1.0]), 50, LoopInputs(reference=np.zeros((1, 1)))).final
        errors.append(np.abs(final.plant - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 1.9)
    assert np.all(orders < 2.2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"reference": np.zeros((9, 6))}, r"reference has shape \(9, 6\), needed is \(10, 6\) or \(1, 6\)"),
        ({"noise": np.zeros((10, 3))}, r"noise has shape \(10, 3\)"),
        ({"disturbance": np.zeros(8)}, r"disturbance has shape \(8,\)"),
        ({"gains": np.zeros(2)}, r"gains has shape \(2,\), needed is \(3,\)"),
        ({"parameters": None}, "parameters is missing, it needs 2 values"),
    ],
)
def test_wrong_input_is_named(kernel: LoopKernel, change: dict[str, np.ndarray | None], message: str) -> None:
    with pytest.raises(InputError, match=message):
        kernel.run(kernel.initial_state(STATE), 10, replace(rich_inputs(10), **change))


def test_state_of_another_loop_is_refused(kernel: LoopKernel) -> None:
    with pytest.raises(InputError, match=r"state.line has shape \(0, 2\), needed is \(1, 2\)"):
        kernel.run(LoopState(STATE, np.zeros(5), np.zeros((0, 2))), 1, rich_inputs(1))


def test_at_least_one_substep_is_needed(chain: LoopFunctions) -> None:
    with pytest.raises(InputError, match="substeps = 0 is not possible"):
        compile_loop(chain, sample_time=SAMPLE_TIME, substeps=0)
