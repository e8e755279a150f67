"""Noise, nominal models and trackers of the blind check."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.validation.blind.draw.conditions import (
    FARTHEST,
    Conditions,
    Tracker,
    believed_values,
    draw_conditions,
    encoder_noise,
    tolerances,
)


def random(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("colour", [0.0, 0.8])
def test_noise_has_its_variance_and_colour(colour: float) -> None:
    noise = encoder_noise(np.array([2e-6, 1e-4]), 200_000, colour, random())
    assert noise.std(axis=0) == pytest.approx([2e-6, 1e-4], rel=0.02)
    neighbours = np.mean(noise[1:] * noise[:-1], axis=0) / noise.var(axis=0)
    assert neighbours == pytest.approx([colour, colour], abs=0.01)


def test_share_of_the_gain_in_coloured_noise_is_that_at_low_frequency() -> None:
    noise = encoder_noise(np.ones(1), 400_000, 0.8, random()).ravel()
    slow = noise.reshape(-1, 1000).mean(axis=1).var() * 1000  # density at low frequency over that of white noise
    assert 1 / slow == pytest.approx(Conditions(colour=0.8).visibility, rel=0.2)


def test_exact_models_are_exact_and_their_logs_clean() -> None:
    robot = load_robot("e12")
    assert believed_values(robot, "exact", random()) == {}
    assert draw_conditions("exact", random()) == Conditions()


def test_wrong_models_are_wrong_within_what_they_declare() -> None:
    robot = load_robot("e12")
    declared = tolerances(robot, "tolerance_3")
    assert declared["body_1.ry.stiffness"] == 0.03
    assert declared["body_1.ry.damping"] == 0.3
    assert {"body_3.mass", "motor_2.inertia"} <= set(declared)
    values = believed_values(robot, "tolerance_3", random())
    off = [np.log(one.value / robot.parameters[name].value) / one.relative for name, one in values.items()]
    assert set(values) == set(declared)
    assert 0.3 < np.std(off) < 2
    assert np.max(np.abs(off)) <= FARTHEST + 1e-9


def test_tracker_sees_distances_as_they_are_but_for_its_target() -> None:
    robot = load_robot("e12")
    pose = np.stack([robot.tool_pose(q) for q in ([0.0, 0.3, 0.0], [0.2, 0.1, 0.0])])
    seen = Tracker.draw(robot, random()).see(pose, random(1))
    true = np.linalg.norm(pose[1, :3] - pose[0, :3])
    assert np.linalg.norm(seen[1] - seen[0]) == pytest.approx(true, abs=0.02)
    assert not np.allclose(seen, pose[:, :3], atol=0.1)
