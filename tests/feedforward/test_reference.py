from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.feedforward.motion import Reference
from flexros.feedforward.reference import compute_reference, reference_chunks
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import Robot, load_robot
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario, load_scenario
from flexros.trajectory import Trajectory
from tests.feedforward.cases import CIRCLE, SMOOTH, joint_trajectory, tool_trajectory

pytestmark = pytest.mark.slow

METHODS = ["none", "rigid", "flexible_joint", "dae"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("chunk", [1, 50])
def test_stream_equals_the_whole_bit_for_bit(method: str, chunk: int, e12: Robot, circle: Trajectory) -> None:
    specification = FeedforwardSpecification.model_validate(
        {"method": method, "friction": {"coulomb": 20, "viscous": 3}}
    )
    whole = compute_reference(e12, circle, specification, 1e-3, 0.12)
    chunks = list(reference_chunks(e12, circle, specification, 1e-3, 0.12, chunk=chunk))
    assert len(whole) == 121
    assert len(chunks) > 1
    joined = Reference.concatenate(chunks)
    for field in fields(Reference):
        np.testing.assert_array_equal(getattr(joined, field.name), getattr(whole, field.name))


@pytest.mark.parametrize("method", METHODS)
def test_shapes_and_start(method: str, e12: Robot, smooth: Trajectory) -> None:
    reference = compute_reference(e12, smooth, FeedforwardSpecification(method=method), 1e-3, 1.0)  # type: ignore[arg-type]
    assert reference.torque.shape == reference.motor_position.shape == reference.motor_velocity.shape == (1001, 2)
    assert reference.output.shape == (1001, 2)
    np.testing.assert_allclose(reference.time, np.arange(1001) * 1e-3)
    np.testing.assert_allclose(reference.motor_position[0], [0, 0.3], atol=1e-12)
    np.testing.assert_allclose(reference.tool_pose[:, [0, 2]], reference.output, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(reference.tool_pose[:, 3:], axis=1), 1.0)


def test_friction_is_added_to_the_torque(e12: Robot, smooth: Trajectory) -> None:
    plain, with_friction = (
        compute_reference(
            e12,
            smooth,
            FeedforwardSpecification.model_validate({"friction": friction, "hold_compensation": False}),
            1e-3,
            0.5,
        )
        for friction in (None, {"viscous": 7.0})
    )
    np.testing.assert_allclose(with_friction.torque - plain.torque, 7.0 * plain.motor_velocity, atol=1e-9)


@pytest.mark.parametrize("method", ["rigid", "flexible_joint", "dae"])
@pytest.mark.parametrize("hold", [True, False])
def test_compensation_equals_friction_inside_the_model(method: str, hold: bool, e12: Robot, smooth: Trajectory) -> None:
    rubbing = e12.with_values({"motor_1.viscous_friction": 300.0, "motor_2.viscous_friction": 150.0})
    settings = {"method": method, "hold_compensation": hold}
    friction = {"viscous": (300.0, 150.0)}
    inside = compute_reference(rubbing, smooth, FeedforwardSpecification.model_validate(settings), 1e-3, 0.5)
    added = compute_reference(
        e12, smooth, FeedforwardSpecification.model_validate({**settings, "friction": friction}), 1e-3, 0.5
    )
    np.testing.assert_allclose(added.torque, inside.torque, atol=1e-5 * np.abs(inside.torque).max())
    np.testing.assert_allclose(added.motor_position, inside.motor_position, atol=1e-11)


def test_delay_of_the_command_is_made_up_for() -> None:
    robot = load_robot("four_mass_linear")
    assert robot.delay == 5e-4
    path = joint_trajectory(robot, [20.0], 1.0)
    on_time = compute_reference(robot.with_values({"delay": 0.0}), path, FeedforwardSpecification(), 5e-4, 1.2)
    early = compute_reference(robot, path, FeedforwardSpecification(), 5e-4, 1.2)
    np.testing.assert_allclose(early.torque[:-1], on_time.torque[1:], atol=1e-6)
    np.testing.assert_array_equal(early.motor_position, on_time.motor_position)


def test_path_for_another_output_is_followed_by_the_rigid_arm(e12: Robot, smooth: Trajectory) -> None:
    reference = compute_reference(e12, smooth, FeedforwardSpecification(output="joints"), 1e-3, 0.9)
    rigid = compute_reference(e12, smooth, FeedforwardSpecification(method="rigid"), 1e-3, 0.9)
    np.testing.assert_allclose(reference.output, rigid.motor_position, atol=1e-12)


def test_start_near_another_configuration(e12: Robot) -> None:
    path = tool_trajectory(e12, CIRCLE, SMOOTH)
    mirrored = np.array([0.35, -0.3, 0.0])
    reference = compute_reference(e12, path, FeedforwardSpecification(), 1e-3, 0.2, near=mirrored)
    assert reference.motor_position[0, 1] < 0
    np.testing.assert_allclose(reference.tool_pose[:, [0, 2]], reference.output, atol=1e-12)


@pytest.mark.parametrize(
    ("sample_time", "duration", "chunk", "sentence"),
    [
        (0.0, 1.0, 10, "sample time of the feedforward is 0 s, but must be positive"),
        (float("nan"), 1.0, 10, "sample time of the feedforward is nan s"),
        (1e-3, -1.0, 10, "duration of the feedforward is -1 s, but must not be negative"),
        (1e-3, 1.0, 0, "chunk of the feedforward is 0 samples, but must be at least 1"),
    ],
)
def test_bad_numbers(
    sample_time: float, duration: float, chunk: int, sentence: str, e12: Robot, smooth: Trajectory
) -> None:
    with pytest.raises(InputError, match=sentence):
        list(reference_chunks(e12, smooth, FeedforwardSpecification(), sample_time, duration, chunk))


@pytest.mark.parametrize("scenario", ["circle_dae", "six_axis_moves", "elbow_moves", "regulator_four_mass"])
def test_commanded_pose_does_not_depend_on_the_method(scenario: str) -> None:
    poses = []
    for method in ("none", "rigid", "flexible_joint", "dae"):
        changed = load_scenario(scenario).with_values({"feedforward.method": method, "duration": 0.3})
        poses.append(Experiment.prepare(changed).reference.tool_pose)
    for pose in poses[1:]:
        np.testing.assert_allclose(pose, poses[0], atol=1e-12)


def test_commanded_pose_of_a_tool_path_with_another_output_is_on_the_path() -> None:
    settings = {
        "robot": "six_axis",
        "trajectory": {
            "output": "tool",
            "path": {"type": "line", "end_from_start": [0, 0.1, 0]},
            "time_law": {"type": "ninth_degree", "duration": 0.4},
        },
        "feedforward": {"method": "dae", "order": 2, "output": "joints"},
        "controller": {"kind": "pid", "kp": 1e5, "kd": 1e3},
    }
    pose = Experiment.prepare(validate(Scenario, settings, "test")).reference.tool_pose
    np.testing.assert_allclose(pose[-1, :3] - pose[0, :3], [0, 0.1, 0], atol=1e-9)
    np.testing.assert_allclose(np.ptp(pose[:, [0, 2]], axis=0), 0, atol=1e-9)
