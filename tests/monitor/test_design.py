"""The design: floors against simulated noise, lifted filters, stable observers."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.monitor.design import LinearFilter, autocovariances, driven_by_noise, floor_ratios
from flexros.monitor.design_book import DesignBook
from flexros.monitor.pose_model import PoseModel

pytestmark = pytest.mark.slow

ROBOTS = ("two_mass", "four_mass_linear", "elbow", "e12", "six_axis", "emps")


def book_of(name: str) -> DesignBook:
    model = load_model(name)
    return DesignBook(model, model.robot.sample_time, round(0.1 / model.robot.sample_time))


def response(system: LinearFilter, inputs: np.ndarray) -> np.ndarray:
    state, outputs = np.zeros(len(system.A)), []
    for one in inputs:
        outputs.append(system.C @ state + system.D @ one)
        state = system.A @ state + system.B @ one
    return np.array(outputs)


def test_a_lifted_filter_says_the_same() -> None:
    design = book_of("elbow").at((0, 0)).design
    inputs = np.random.default_rng(1).normal(size=(60, 2))
    lifted = response(design.filter.lifted(10), inputs.reshape(6, 20))
    np.testing.assert_allclose(lifted.reshape(60, 4), response(design.filter, inputs), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["four_mass_linear", "e12"])
def test_floors_are_those_of_simulated_noise(name: str) -> None:
    book = book_of(name)
    design = book.at(book.home).design
    system = driven_by_noise(design.pose, design.gain, design.filter)
    noise = book.noise * np.random.default_rng(2).normal(size=(60_000, len(book.noise)))
    outputs = response(system, noise)[2000:]
    expected = np.concatenate([design.spread, design.torque_spread])
    np.testing.assert_allclose(outputs.std(axis=0), expected, rtol=0.06)


def test_autocovariances_are_those_of_simulated_noise() -> None:
    book = book_of("four_mass_linear")
    design = book.at(book.home).design
    system = driven_by_noise(design.pose, design.gain, design.filter)
    outputs = response(system, book.noise * np.random.default_rng(4).normal(size=(100_000, 1)))[2000:]
    known = autocovariances(design, design.pose, book.noise, 41)
    assert known[0] == pytest.approx(1.0)
    for lag in (1, 10, 40):
        found = np.mean(outputs[lag:] * outputs[:-lag], axis=0) / outputs.var(axis=0)
        np.testing.assert_allclose(found, known[lag], atol=0.03)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_observer_is_stable_in_every_pose(name: str) -> None:
    book, poses = book_of(name), PoseModel(load_model(name).robot, load_model(name).robot.sample_time)
    rng = np.random.default_rng(5)
    for _ in range(5):
        pose = poses.at(poses.home + rng.uniform(-1.0, 1.0, len(poses.home)))
        errors = pose.transition @ (np.eye(len(book.gain)) - book.gain @ pose.readout)
        assert np.abs(np.linalg.eigvals(errors)).max() < 1.0


def test_a_constant_torque_at_a_motor_is_told() -> None:
    """The mean of the disturbance torque is right, for a robot under gravity with elastic arms."""
    book = book_of("elbow")
    design = book.at(book.home).design
    pose = design.pose
    wanted, error, found = np.array([5.0, -2.0]), np.zeros(len(design.gain)), np.zeros(len(design.filter.A))
    for _ in range(4000):
        e = pose.readout @ error
        torque = (design.filter.C @ found + design.filter.D @ e)[2:]
        found = design.filter.A @ found + design.filter.B @ e
        error = pose.transition @ (error - design.gain @ e) + pose.push @ pose.motor @ wanted
    np.testing.assert_allclose(torque, wanted, rtol=1e-3)


def test_floors_hardly_change_within_a_cell() -> None:
    book = book_of("six_axis")
    robot = load_model("six_axis").robot
    poses = PoseModel(robot, robot.sample_time)
    edge = poses.at(poses.home + 0.2)
    ratio = floor_ratios(book.at(book.home).design, edge, book.noise)
    np.testing.assert_allclose(ratio, 1.0, atol=0.05)


def test_gears_that_stiffen_are_other_situations() -> None:
    book = book_of("four_mass")
    home = book.at(book.home).design
    ratios = [floor_ratios(home, pose, book.noise)[1] for pose in book.situations()]
    assert ratios[0] == pytest.approx(1.0)
    assert max(ratios) > 1.5
    assert len(book_of("four_mass_linear").situations()) == 1
