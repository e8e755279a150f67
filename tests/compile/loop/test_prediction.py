"""The predictor of constant gain: without gain, with gain, through gaps, and in parallel lanes."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from flexros.compile import LoopFunctions, LoopInputs, LoopState, compile_loop
from flexros.compile.loop.prediction import LoopPrediction, PredictionLoop
from tests.compile.conftest import PARAMETERS, SAMPLE_TIME, STATE, integrator, unstable

N = 60
LANES = 4


def torques(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(N, 2)) * 30.0


def one_lane(loop: PredictionLoop, torque: np.ndarray, position: np.ndarray, **given: object) -> LoopPrediction:
    """Run a loop around the chain, every sample measured, with a gain unless another is given."""
    gain = np.random.default_rng(5).normal(size=(10, 2)) * 0.05
    keys: dict[str, object] = {"gain": gain, "valid": np.ones(len(position)), "start": STATE, **given}
    parameters = keys.pop("parameters", np.repeat(PARAMETERS[:, None], loop.lanes, axis=1))
    return loop.run(keys.pop("start"), parameters, keys.pop("gain"), torque, position, keys.pop("valid"), **keys)


@pytest.fixture(scope="module")
def loop(chain: LoopFunctions) -> PredictionLoop:
    return PredictionLoop(chain, sample_time=SAMPLE_TIME, delay=1.7 * SAMPLE_TIME, substeps=2)


@pytest.fixture(scope="module")
def lanes(chain: LoopFunctions) -> PredictionLoop:
    return PredictionLoop(chain, sample_time=SAMPLE_TIME, delay=1.7 * SAMPLE_TIME, substeps=2, lanes=LANES)


def test_without_gain_it_is_the_open_loop(chain: LoopFunctions, loop: PredictionLoop) -> None:
    c, r, y, g = ca.SX.sym("c", 0), ca.SX.sym("r", 2), ca.SX.sym("y", 2), ca.SX.sym("g", 0)
    open_loop = replace(chain, controller=ca.Function("controller", [c, r, y, g], [r, c]))
    kernel = compile_loop(open_loop, sample_time=SAMPLE_TIME, delay=1.7 * SAMPLE_TIME, substeps=2)
    start = LoopState(STATE, np.zeros(0), np.zeros((loop.line_length, 2)))
    expected = kernel.run(start, N, LoopInputs(reference=torques(), parameters=PARAMETERS), record_states=True)
    prediction = one_lane(
        loop, torques(), np.zeros((N, 2)), gain=np.zeros((10, 2)), past=np.zeros((loop.line_length, 2)),
        pose_samples=np.arange(N), record_states=True,
    )  # fmt: skip
    np.testing.assert_array_equal(prediction.states[:, :, 0], expected.states)
    np.testing.assert_array_equal(-prediction.innovation[:, :, 0], expected.encoder)
    np.testing.assert_array_equal(prediction.tool_pose[:, :, 0], expected.tool_pose)
    np.testing.assert_array_equal(prediction.final[:, 0], expected.final.plant)


def test_with_gain_it_is_the_kalman_filter_of_a_linear_system() -> None:
    """A mass with position and speed: its motion under constant force is exact."""
    x, u, w, p = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("w", 6), ca.SX.sym("p")
    mass = replace(
        integrator(),
        derivative=ca.Function("derivative", [x, u, w, p], [ca.vertcat(x[1], u / p)]),
        encoder=ca.Function("encoder", [x], [x[0]]),
        tool_pose=ca.Function("tool_pose", [x, p], [ca.vertcat(x[0], 0, 0, 0, 0, 0, 1)]),
    )
    T, m = 0.1, 2.0
    loop = PredictionLoop(mass, sample_time=T)
    rng = np.random.default_rng(0)
    torque, position, K = rng.normal(size=(N, 1)), rng.normal(size=(N, 1)), np.array([[0.6], [1.5]])
    prediction = loop.run(np.array([0.3, -0.1]), np.array([[m]]), K, torque, position, np.ones(N), record_states=True)
    F, G = np.array([[1.0, T], [0.0, 1.0]]), np.array([T**2 / 2, T]) / m
    state = np.array([0.3, -0.1])
    for k in range(N):
        error = position[k, 0] - state[0]
        assert prediction.innovation[k, 0, 0] == pytest.approx(error, abs=1e-12)
        state = state + K[:, 0] * error
        np.testing.assert_allclose(prediction.states[k, :, 0], state, atol=1e-12)
        state = F @ state + G * torque[k, 0]
    np.testing.assert_allclose(prediction.final[:, 0], state, atol=1e-12)


def test_through_a_gap_the_model_runs_on_alone(loop: PredictionLoop) -> None:
    position = np.random.default_rng(1).normal(size=(N, 2))
    valid = np.ones(N)
    valid[20:35] = 0.0
    spoilt = position.copy()
    spoilt[20:35] = 1e6
    prediction = one_lane(loop, torques(), spoilt, valid=valid, record_states=True)
    assert not np.any(prediction.innovation[20:35])
    whole = one_lane(loop, torques(), position, record_states=True)
    np.testing.assert_array_equal(prediction.states[:20], whole.states[:20])
    started = one_lane(loop, torques()[:19], position[:19], record_states=True).final[:, 0]
    alone = one_lane(
        loop, torques()[19:35], position[19:35], start=started, past=torques()[18 - np.arange(loop.line_length)],
        valid=np.concatenate([[1.0], np.zeros(15)]), record_states=True,
    )  # fmt: skip
    np.testing.assert_array_equal(alone.states, prediction.states[19:35])


def test_run_in_two_parts_with_its_past_equals_one_run(loop: PredictionLoop) -> None:
    position = np.random.default_rng(2).normal(size=(N, 2))
    whole = one_lane(loop, torques(), position)
    first = one_lane(loop, torques()[:23], position[:23])
    past = torques()[22 - np.arange(loop.line_length)]
    second = one_lane(loop, torques()[23:], position[23:], start=first.final[:, 0], past=past)
    np.testing.assert_array_equal(second.innovation, whole.innovation[23:])


def test_before_the_first_sample_its_torque_acted(loop: PredictionLoop) -> None:
    position = np.zeros((N, 2))
    past = np.repeat(torques()[:1], loop.line_length, axis=0)
    np.testing.assert_array_equal(
        one_lane(loop, torques(), position).innovation, one_lane(loop, torques(), position, past=past).innovation
    )


def test_lanes_have_parameters_starts_and_torques_of_their_own(loop: PredictionLoop, lanes: PredictionLoop) -> None:
    position = np.random.default_rng(3).normal(size=(N, 2))
    scale = 1 + 0.1 * np.arange(LANES)
    torque = np.stack([torques(seed) for seed in range(LANES)], axis=-1)
    start = np.outer(STATE, scale)
    prediction = one_lane(lanes, torque, position, start=start, parameters=np.outer(PARAMETERS, scale))
    for lane in range(LANES):
        expected = one_lane(
            loop, torque[:, :, lane], position, start=start[:, lane], parameters=PARAMETERS[:, None] * scale[lane]
        )
        np.testing.assert_array_equal(prediction.innovation[:, :, lane], expected.innovation[:, :, 0])


def test_pasts_of_lanes_are_their_own(loop: PredictionLoop, lanes: PredictionLoop) -> None:
    position = np.zeros((N, 2))
    past = np.random.default_rng(4).normal(size=(loop.line_length, 2, LANES)) * 100
    prediction = one_lane(lanes, torques(), position, past=past)
    for lane in range(LANES):
        expected = one_lane(loop, torques(), position, past=past[:, :, lane])
        np.testing.assert_array_equal(prediction.innovation[:, :, lane], expected.innovation[:, :, 0])


def test_poses_are_those_of_the_samples_asked_for_before_their_correction(loop: PredictionLoop) -> None:
    position = np.random.default_rng(6).normal(size=(N, 2))
    full = one_lane(loop, torques(), position, pose_samples=np.arange(N))
    few = one_lane(loop, torques(), position, pose_samples=np.array([0, 7, 41]))
    np.testing.assert_array_equal(few.tool_pose, full.tool_pose[[0, 7, 41]])
    assert full.tool_pose[0, 0, 0] == pytest.approx(0.5 * np.sin(np.cumsum(STATE[:3])).sum())
    assert one_lane(loop, torques(), position).tool_pose is None


def test_each_motor_has_its_own_delay() -> None:
    """Two integrators under the torques 1, 2, 3, ..., delayed by 1.5 and 0.25 s; T = 1 s."""
    x, u, w, p = ca.SX.sym("x", 2), ca.SX.sym("u", 2), ca.SX.sym("w", 6), ca.SX.sym("p", 0)
    c, r, y, g = ca.SX.sym("c", 0), ca.SX.sym("r"), ca.SX.sym("y", 2), ca.SX.sym("g", 0)
    functions = LoopFunctions(
        derivative=ca.Function("derivative", [x, u, w, p], [u]),
        encoder=ca.Function("encoder", [x], [x]),
        tool_pose=ca.Function("tool_pose", [x, p], [ca.vertcat(x, 0, 0, 0, 0, 1)]),
        controller=ca.Function("controller", [c, r, y, g], [ca.vertcat(r, r), c]),
    )
    loop = PredictionLoop(functions, sample_time=1.0, delay=(1.5, 0.25))
    torque = np.repeat(np.arange(1.0, 6.0)[:, None], 2, axis=1)
    prediction = loop.run(
        np.zeros(2), np.zeros((0, 1)), np.zeros((2, 2)), torque, np.zeros((5, 2)), np.ones(5),
        past=np.zeros((loop.line_length, 2)),
    )  # fmt: skip
    np.testing.assert_allclose(-prediction.innovation[:, 0, 0], [0, 0, 0.5, 2, 4.5], atol=1e-14)
    np.testing.assert_allclose(-prediction.innovation[:, 1, 0], [0, 0.75, 2.5, 5.25, 9], atol=1e-14)


def test_a_lane_that_diverges_is_reported_and_does_not_affect_the_others() -> None:
    loop = PredictionLoop(unstable(), sample_time=0.1, lanes=2)
    prediction = loop.run(
        np.array([1.0]), np.array([[50.0, 0.0]]), np.zeros((1, 1)), np.zeros((N, 1)), np.zeros((N, 1)), np.ones(N)
    )
    assert 0 <= prediction.diverged[0] < N
    assert prediction.diverged[1] == -1
    assert np.all(prediction.innovation[:, 0, 1] == -1.0)
    assert not np.all(np.isfinite(prediction.innovation[:, 0, 0]))


def test_what_is_given_is_not_changed(loop: PredictionLoop) -> None:
    start, torque, position = STATE.copy(), torques(), np.ones((N, 2))
    one_lane(loop, torque, position, start=start)
    np.testing.assert_array_equal(start, STATE)
    np.testing.assert_array_equal(torque, torques())
    assert np.all(position == 1.0)
