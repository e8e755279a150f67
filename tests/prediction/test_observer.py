"""The gain is that of a stationary Kalman filter, and what noise makes of the errors is as it says."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm

from flexros.prediction.observer import (
    ARM_SHARE,
    ObserverGain,
    _noise_of_kind,
    kalman_gain,
    observer_gain,
    passed_on,
)
from flexros.robot import Robot, load_robot
from flexros.robot.linear.linearise import linear_model
from flexros.robot.motors import list_motors

STEP = 5e-4
ROBOT = load_robot("four_mass_linear")
NOISE = np.array([1e-4])


def process_noise(robot: Robot, level: float, noise: float) -> np.ndarray:
    """Covariance of the torques: each moves its mass by a share of the noise within one sample."""
    inertia = np.diag(linear_model(robot).mass)
    share = np.where(np.arange(len(inertia)) < robot.n_arm, ARM_SHARE, 1.0)
    return np.diag((level * inertia * noise / STEP**2 * share) ** 2)


@pytest.mark.parametrize("level", [1e-3, 0.3])
def test_it_is_the_gain_of_a_kalman_filter(level: float) -> None:
    """A filter that begins with any covariance ends with this gain."""
    found = observer_gain(ROBOT, STEP, level, NOISE)
    A, *_ = linear_model(ROBOT).matrices()
    n = ROBOT.n_coordinates
    F = expm(A * STEP)
    G = np.vstack([np.zeros((n, n)), np.linalg.inv(linear_model(ROBOT).mass) * STEP])
    Q, R, C = G @ process_noise(ROBOT, level, NOISE[0]) @ G.T / NOISE[0] ** 2, np.eye(1), found.readout
    P = np.eye(2 * n)
    for _ in range(20_000):
        K = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
        keep = np.eye(2 * n) - K @ C
        P = F @ (keep @ P @ keep.T + K @ R @ K.T) @ F.T + Q
    np.testing.assert_allclose(found.gain, K, rtol=1e-6, atol=1e-9 * np.abs(K).max())


def errors(found: ObserverGain, samples: int, horizon: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Let many filters run on noise alone; returns standard deviations of their errors now and some samples ahead."""
    rng = np.random.default_rng(seed)
    C, K, F = found.readout, found.gain, found.motion
    vectors = np.linalg.eigh(found.taken)
    shape = vectors[1] * np.sqrt(np.maximum(vectors[0], 0.0))
    x = np.zeros((len(F), 1000))
    e = np.zeros((len(C), 1000))
    for _ in range(samples):
        e = found.noise[:, None] * rng.normal(size=e.shape) - C @ x
        x = F @ (x + K @ e) + shape @ rng.normal(size=x.shape)
    later = x
    for _ in range(horizon - 1):
        later = F @ later + shape @ rng.normal(size=x.shape)
    return e.std(axis=1), (found.noise[:, None] * rng.normal(size=e.shape) - C @ later).std(axis=1)


@pytest.mark.parametrize("tolerated", [None, np.array([0.3])])
def test_errors_without_gap_have_the_spread_that_it_states(tolerated: np.ndarray | None) -> None:
    found = observer_gain(ROBOT, STEP, 0.1, NOISE, tolerated=tolerated)
    now, ahead = errors(found, found.settling, 40)
    np.testing.assert_allclose(now, found.spread, rtol=0.08)
    np.testing.assert_allclose(ahead, found.ahead(40), rtol=0.08)
    assert found.spread[0] > NOISE[0]


def test_of_the_errors_measurement_noise_alone_makes_those_without_torques() -> None:
    lenient = observer_gain(ROBOT, STEP, 0.1, NOISE, tolerated=np.array([0.3]))
    now, _ = errors(replace(lenient, taken=np.zeros_like(lenient.taken)), lenient.settling, 1)
    np.testing.assert_allclose(now, lenient.spread_of_noise, rtol=0.08)
    assert lenient.spread_of_noise[0] < 0.97 * lenient.spread[0]
    exact = observer_gain(ROBOT, STEP, 0.1, NOISE)
    np.testing.assert_allclose(exact.spread_of_noise, exact.spread)


def test_an_error_of_the_start_decays_to_a_thousandth() -> None:
    found = observer_gain(ROBOT, STEP, 0.1, NOISE)
    decayed = np.linalg.matrix_power(found.transition, found.settling)
    slowest = np.abs(np.linalg.eigvals(decayed)).max()
    assert slowest <= 1e-3
    assert slowest > 0.9e-3


def test_behind_a_known_start_errors_grow_to_their_spread() -> None:
    gain = observer_gain(ROBOT, STEP, 1e-3, NOISE)
    early = gain.early(3 * gain.settling)
    np.testing.assert_allclose(early[0], NOISE)
    assert np.all(np.diff(early[:, 0]) >= -1e-9 * NOISE)
    np.testing.assert_allclose(early[-1], gain.spread, rtol=1e-6)


def test_tolerated_torques_are_part_of_the_spread() -> None:
    exact, lenient = (
        observer_gain(ROBOT, STEP, 1e-3, NOISE, tolerated=tolerated) for tolerated in (None, np.array([0.1]))
    )
    assert lenient.spread[0] > 1.05 * exact.spread[0]
    assert lenient.ahead(100)[0] > 2 * exact.ahead(100)[0]
    assert not exact.taken.any()


def test_a_spring_passes_on_the_share_of_the_torque_that_moves_the_arm() -> None:
    robot = load_robot("two_mass")
    mass = linear_model(robot).mass
    np.testing.assert_allclose(np.diag(mass), [6.0, 4.0])
    np.testing.assert_allclose(passed_on(robot, mass, np.array([0.5])), [0.5 * 6 / 10, 0.5])


def test_springs_carry_the_torques_of_locked_springs() -> None:
    """Accelerations of the locked robot are held up by the torques at the arm alone, for one motor after the other."""
    robot = load_robot("e12")
    mass, motors = linear_model(robot).mass, list(robot.motor_rows)
    carried = np.zeros((robot.n_coordinates, robot.n_motors))
    for motor in range(robot.n_motors):
        alone = np.eye(robot.n_motors)[motor]
        carried[:, motor] = passed_on(robot, mass, alone)
        np.testing.assert_allclose(carried[motors, motor], alone)
    locked = np.vstack([robot.arm_from_gears(np.eye(robot.n_motors)).T, np.eye(robot.n_motors)])
    accelerations = locked @ np.linalg.solve(locked.T @ mass @ locked, np.eye(robot.n_motors))
    np.testing.assert_allclose(carried[: robot.n_arm], np.abs(mass @ accelerations)[: robot.n_arm], atol=1e-12)


def test_a_rigid_axis_tolerates_the_torque_at_its_motor_alone() -> None:
    robot = load_robot("emps")
    np.testing.assert_array_equal(passed_on(robot, linear_model(robot).mass, np.array([0.3])), [0.3])


def test_tolerated_torques_correct_an_undamped_arm() -> None:
    """Without them at the arm an error of its vibration would last for ever: the level alone takes minutes."""
    two_mass = load_robot("two_mass")
    robot = two_mass.with_values({"body_1.rz.damping": 0.0})
    tolerant = observer_gain(robot, 2e-3, 2e-4, np.array([1e-5]), tolerated=np.array([5.0]))
    exact = observer_gain(robot, 2e-3, 2e-4, np.array([1e-5]))
    assert tolerant.settling * 2e-3 < 1.0
    assert exact.settling > 5 * tolerant.settling


def test_the_more_torque_noise_the_more_a_measurement_counts() -> None:
    found = [observer_gain(ROBOT, STEP, level, NOISE) for level in (1e-3, 1e-2, 1e-1)]
    corrections = [float((one.readout @ one.gain)[0, 0]) for one in found]
    assert 0 < corrections[0] < corrections[1] < corrections[2] < 1


def test_the_gain_does_not_depend_on_the_unit_of_the_noise() -> None:
    """Level and noise set the torque noise together, so both scale the spread alone."""
    fine, coarse = (observer_gain(ROBOT, STEP, 1e-2, noise) for noise in (NOISE, 1000 * NOISE))
    np.testing.assert_allclose(fine.gain, coarse.gain, rtol=1e-9)
    np.testing.assert_allclose(1000 * fine.spread, coarse.spread, rtol=1e-9)


def test_gravity_of_the_pose_is_part_of_it() -> None:
    elbow = load_robot("elbow")
    noise = np.full(elbow.n_motors, 1e-5)
    home = observer_gain(elbow, STEP, 1e-2, noise)
    other = observer_gain(elbow, STEP, 1e-2, noise, elbow.home[: elbow.n_arm] + 0.5)
    assert np.abs(home.gain - other.gain).max() > 1e-3 * np.abs(home.gain).max()


def test_motors_that_turn_and_that_slide_have_noise_of_their_own_kind() -> None:
    """One level fits radians and metres, as of a linear axis that carries a rotary one."""
    robot = load_robot("e12")
    noise = np.array([1e-6, 3e-6])
    np.testing.assert_allclose(_noise_of_kind(robot, noise), 2e-6)
    joints = tuple(replace(joint, rotary=number != robot.gear_rows[0]) for number, joint in enumerate(robot.joints))
    mixed = SimpleNamespace(
        joints=joints,
        motors=list_motors(replace(robot.chain, joints=joints)),
        motor_rows=robot.motor_rows,
        n_arm=robot.n_arm,
        n_coordinates=robot.n_coordinates,
    )
    found = _noise_of_kind(mixed, noise)
    places = robot.motor_rows
    assert found[places[0]] == 1e-6
    assert found[places[1]] == 3e-6


def refuses(*_: object) -> None:
    raise ValueError("Reordering of (A, B) failed")


@pytest.mark.parametrize("level", [1e-5, 1.0])
def test_where_eigenvalues_cannot_be_sorted_the_gain_is_that_of_doubling(
    level: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With encoders of 2e-5 rad, a play of a gear that a proposed experiment simulated could not be diagnosed."""
    robot = load_robot("six_axis")
    noise = np.full(robot.n_motors, 2e-5)
    sorted_gain = observer_gain(robot, 0.002, level, noise).gain
    monkeypatch.setattr("flexros.prediction.observer.solve_discrete_are", refuses)
    np.testing.assert_allclose(observer_gain(robot, 0.002, level, noise).gain, sorted_gain, rtol=1e-5, atol=1e-9)


def test_a_mode_that_no_encoder_sees_and_that_grows_has_no_gain(monkeypatch: pytest.MonkeyPatch) -> None:
    F, C = np.diag([1.2, 0.5]), np.array([[0.0, 1.0]])
    with pytest.raises(np.linalg.LinAlgError):
        kalman_gain(F, C, np.eye(2), np.eye(1))
