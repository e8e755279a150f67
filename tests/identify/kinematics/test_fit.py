"""Identification of simulated robots: accuracy, intervals, and the elastostatics against the full model."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.errors import InputError
from flexros.identify.kinematics.design import candidate_poses, optimal_poses
from flexros.identify.kinematics.elastostatics import elastostatics, measured_points
from flexros.identify.kinematics.fit import fit_kinematics
from flexros.identify.kinematics.record import PoseRecord
from flexros.identify.kinematics.result import kinematic_record
from flexros.identify.kinematics.unknowns import KinematicPrior, Unknowns, unknowns
from flexros.robot import load_robot, robot_from_data

pytestmark = pytest.mark.slow

NOISE = 5e-5
LOADS = (0.0, 100.0, 200.0)


@pytest.fixture(scope="module")
def six_axis() -> Unknowns:
    return unknowns(load_robot("six_axis"))


@pytest.fixture(scope="module")
def poses(six_axis: Unknowns) -> PoseRecord:
    candidates = candidate_poses(six_axis, LOADS, 200)
    return candidates.rows(optimal_poses(six_axis, candidates, 50, NOISE))


def measured(unknown: Unknowns, theta: FloatArray, poses: PoseRecord, noise: float, seed: int) -> PoseRecord:
    """Measure with the full model of the plant: a robot file with the deviations, the load as a body of its own."""
    from scipy.spatial.transform import Rotation

    true = unknown.robot.with_values(dict(zip(unknown.parameters, unknown.values(theta), strict=True)))
    robots, points = {}, []
    for load in set(poses.load.tolist()):
        data = true.spec.model_dump()
        if load:
            data["bodies"] = [*data["bodies"], {"mass": {"value": load}}]
        robots[load] = robot_from_data(data, "loaded")
    for motors, load in zip(poses.motor_position, poses.load.tolist(), strict=True):
        loaded = robots[load]
        points.append(loaded.tool_pose(loaded.equilibrium(motor_position=motors)[: loaded.n_arm])[:3])
    frame = theta[len(unknown.parameters) :]
    tool = frame[:3] + Rotation.from_rotvec(frame[3:]).apply(np.array(points))
    return PoseRecord(
        poses.motor_position, poses.load, tool + noise * np.random.default_rng(seed).normal(size=tool.shape)
    )


def test_elastostatics_agree_with_the_equilibrium_of_the_plant(six_axis: Unknowns) -> None:
    theta = np.random.default_rng(1).normal(size=len(six_axis.names)) * six_axis.deviation
    few = candidate_poses(six_axis, LOADS, 3, seed=4)
    true = measured(six_axis, theta, few, 0.0, 0)
    points, _ = measured_points(six_axis, few, theta)
    np.testing.assert_allclose(points, true.tool, atol=1e-9)


def test_slopes_are_derivatives(six_axis: Unknowns) -> None:
    rng = np.random.default_rng(2)
    theta, few = rng.normal(size=len(six_axis.names)) * six_axis.deviation, candidate_poses(six_axis, LOADS, 2, seed=5)
    _, slopes = measured_points(six_axis, few, theta)
    for k in range(0, len(theta), 5):
        step = np.zeros(len(theta))
        step[k] = 1e-5
        ends = [measured_points(six_axis, few, theta + sign * step)[0] for sign in (1, -1)]
        np.testing.assert_allclose(slopes[:, :, k], (ends[0] - ends[1]) / 2e-5, atol=1e-7)


def test_ten_millimetres_become_less_than_half_a_millimetre(six_axis: Unknowns, poses: PoseRecord) -> None:
    rng = np.random.default_rng(5)
    theta = rng.normal(size=len(six_axis.names)) * six_axis.deviation
    fit = fit_kinematics(six_axis, measured(six_axis, theta, poses, NOISE, 1))
    elsewhere = measured(six_axis, theta, candidate_poses(six_axis, LOADS, 12, seed=9), 0.0, 0)
    before, after = fit.errors(elsewhere, nominal=True), fit.errors(elsewhere)
    assert 1e3 * before.max() > 8
    assert 1e3 * after.max() < 0.2
    assert fit.noise == pytest.approx(NOISE, rel=0.3)
    _, slopes = measured_points(six_axis, elsewhere, fit.theta)
    variance = np.einsum("nip,pq,niq->n", slopes, fit.covariance, slopes)  # of predicted tool points
    assert np.sqrt(np.mean(after**2 / variance)) < 2.0
    assert fit.robot().parameters["body_3.ry.stiffness"].value != six_axis.nominal[0]


def test_intervals_cover_the_truth(six_axis: Unknowns, poses: PoseRecord) -> None:
    inside = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        theta = rng.normal(size=len(six_axis.names)) * six_axis.deviation
        points, _ = measured_points(six_axis, poses, theta)
        noisy = PoseRecord(poses.motor_position, poses.load, points + NOISE * rng.normal(size=points.shape))
        fit = fit_kinematics(six_axis, noisy, NOISE)
        inside.append(np.abs(fit.theta - theta) < 1.96 * fit.deviations)
    assert 0.90 < np.mean(inside) < 0.99


def test_optimal_poses_tell_more_than_random_ones(six_axis: Unknowns, poses: PoseRecord) -> None:
    def uncertainty(record: PoseRecord) -> float:
        _, slopes = measured_points(six_axis, record, np.zeros(len(six_axis.names)))
        scaled = (slopes * six_axis.deviation / NOISE).reshape(-1, slopes.shape[2])
        return float(np.linalg.slogdet(np.eye(scaled.shape[1]) + scaled.T @ scaled)[1])

    assert uncertainty(poses) > uncertainty(candidate_poses(six_axis, LOADS, 50, seed=3)) + 5


def test_rigid_gears_and_a_robot_in_a_plane() -> None:
    robot = load_robot("elbow")
    unknown = unknowns(robot, KinematicPrior(length=1e-3, angle=1e-3, compliance=0.3))
    assert {"body_1.length.x", "motor_1.zero"} & set(unknown.names) == {"body_1.length.x"}
    poses = candidate_poses(unknown, (0.0, 50.0), 30)
    theta = np.random.default_rng(0).normal(size=len(unknown.names)) * unknown.deviation
    fit = fit_kinematics(unknown, measured(unknown, theta, poses, 1e-5, 0))
    assert 1e3 * fit.errors(measured(unknown, theta, candidate_poses(unknown, (25.0,), 5, seed=2), 0, 0)).max() < 0.1


def test_record_and_robot_file(six_axis: Unknowns, poses: PoseRecord) -> None:
    theta = np.random.default_rng(3).normal(size=len(six_axis.names)) * six_axis.deviation
    points, _ = measured_points(six_axis, poses, theta)
    fit = fit_kinematics(six_axis, PoseRecord(poses.motor_position, poses.load, points), NOISE)
    record = kinematic_record(fit)
    rows = {row["name"]: row for row in record["parameters"]}
    # the zero of the first axis and the tracker's frame cannot be told apart: only their sum is known
    assert not rows["body_1.length.z"]["determined"]
    assert rows["body_3.ry.stiffness"]["determined"]
    text = fit.robot_text("identified")
    assert "zero:" in text
    assert "identified" in text


def test_model_without_geometry_is_refused() -> None:
    with pytest.raises(InputError, match="no geometry"):
        elastostatics(load_robot("four_mass"), ())


def test_too_few_poses_are_refused(six_axis: Unknowns) -> None:
    with pytest.raises(InputError, match="at least 4"):
        fit_kinematics(six_axis, candidate_poses(six_axis, LOADS, 3))


def test_nothing_that_is_unknown_is_refused() -> None:
    with pytest.raises(InputError, match="nothing of robot elbow is unknown"):
        unknowns(load_robot("elbow"), KinematicPrior(length=0, angle=0, compliance=0))
