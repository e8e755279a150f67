"""Rigid models recovered from simulated robots, and from a measured drive."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.rigid.fit import cross_test, fit_rigid
from flexros.identify.rigid.settings import RigidSettings
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.robot import load_robot
from flexros.robot.robot import LIBRARY
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

REALDATA = os.environ.get("FLEXROS_REALDATA", "")
NEEDS_EMPS = pytest.mark.skipif(
    not REALDATA or not (Path(REALDATA) / "emps").is_dir(),
    reason="FLEXROS_REALDATA is unset or names no folder with emps/, the measured drive",
)
SLOW = RigidSettings(cutoff=25.0)


def friction(v: np.ndarray) -> np.ndarray:
    return 10 * np.sign(v) + 3


def truth(fit) -> np.ndarray:
    values = fit.base.nominal.copy()
    for place, name in enumerate(fit.base.names):
        values[place] += 10 * name.endswith("coulomb_friction") + 3 * name.endswith("torque_offset")
    return values


@pytest.mark.slow
@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(("name", "samples"), [("elbow", 10_000), ("e12", 10_000), ("six_axis", 5000)])
def test_base_parameters_and_torques_are_recovered(name: str, samples: int, fourier_motion, rigid_log) -> None:
    robot = load_robot(name)
    log = rigid_log(robot, fourier_motion(samples, 1e-3, robot.n_motors), noise=2e-6, friction=friction)
    fit = fit_rigid(log, robot, SLOW)
    assert fit.rich_enough
    assert fit.moving.all()
    error = np.abs(fit.values - truth(fit))
    inertial = [place for place, unit in enumerate(fit.base.units) if unit.startswith("kg")]
    largest = max(np.abs(truth(fit)[inertial]))
    assert error[inertial].max() < 1e-3 * largest
    assert fit.error.total < 0.05
    motion = fourier_motion(samples, 1e-3, robot.n_motors, seed=9)
    other = rigid_log(robot, motion, noise=2e-6, friction=friction, seed=4)
    assert cross_test(fit, other).total < 0.1


def test_a_motor_without_torque_is_left_out(elbow, fourier_motion, rigid_log) -> None:
    log = rigid_log(elbow, fourier_motion(4000, 1e-3, elbow.n_motors), noise=2e-6, friction=friction)
    commands = log.joint_commands
    wrong = commands.effort.copy()
    wrong[:, 1] = 40 * np.random.default_rng(0).normal(size=len(wrong))
    spoilt = replace(log, joint_commands=replace(commands, effort=wrong))
    fit = fit_rigid(spoilt, elbow, SLOW.model_copy(update={"prescribed": ("motor_2",)}))
    found, expected = dict(zip(fit.base.names, fit.values)), dict(zip(fit.base.names, truth(fit)))
    assert found["motor_1.coulomb_friction"] == pytest.approx(expected["motor_1.coulomb_friction"], rel=0.02)
    assert fit.error.total < 0.5
    assert np.isnan(fit.error.motors[1])
    assert any("motor_2.coulomb_friction" in one.name for one in fit.excitation.not_excited)
    assert found["motor_2.coulomb_friction"] == 0.0  # nominal


@pytest.mark.slow
@pytest.mark.usefixtures("unchecked")
def test_standard_deviations_fit_the_spread(elbow, fourier_motion, rigid_log) -> None:
    motion = fourier_motion(8000, 1e-3, 2)
    scores = []
    for seed in range(12):
        fit = fit_rigid(rigid_log(elbow, motion, noise=2e-5, friction=friction, seed=seed), elbow, SLOW)
        scores.append((fit.values - truth(fit)) / fit.deviation)
    assert 0.6 < np.std(scores) < 1.6


@pytest.mark.slow
def test_closed_loop_of_the_rigid_elbow_under_gravity(tmp_path: Path) -> None:
    file = tmp_path / "elbow_rigid.yaml"
    file.write_text(re.sub(r"spring: \S+ damper: \d+", "spring: rigid", (LIBRARY / "elbow.yaml").read_text()))
    points = [[0.5, 0.2], [0.8, -0.6], [-0.6, 0.8], [0.1, -0.4], [-0.8, 0.5], [0.6, 0.7], [0.3, -0.9], [0, 0]]
    changes = {"robot": str(file), "feedforward.method": "rigid", "trajectory.path.points_from_start": points}
    experiment = Experiment.prepare(load_scenario("elbow_moves").with_values(changes, "test"))
    log = closed_loop(experiment)
    sampled = fit_rigid(log, experiment.plant, RigidSettings(cutoff=30.0))
    held = fit_rigid(log, experiment.plant, RigidSettings(cutoff=30.0, hold=True))
    assert held.rich_enough
    gravity = held.base.names.index("body_1.first_moment.z")
    assert held.values[gravity] == pytest.approx(60 * 0.4 + 45 * 0.9, rel=1e-3)
    scale = np.maximum(np.abs(held.base.nominal), 10.0)
    assert np.all(np.abs(held.values - held.base.nominal) < 2e-3 * scale)
    assert held.error.total < 0.05
    assert sampled.error.total > 5 * held.error.total  # half a sample of time is visible


def test_motor_that_stands_still_keeps_its_nominal_values(elbow, fourier_motion, rigid_log) -> None:
    motion = fourier_motion(8000, 1e-3, 2)
    motion[:, :, 1] = 0
    fit = fit_rigid(rigid_log(elbow, motion, noise=1e-5), elbow, SLOW)
    assert fit.moving.tolist() == [True, False]
    assert not fit.rich_enough
    place = fit.base.names.index("motor_2.inertia")
    assert fit.values[place] == fit.base.nominal[place]
    assert fit.deviation[place] == 0
    assert "motor_2.inertia" in [entry.name for entry in fit.excitation.not_excited]
    assert fit.error.total < 0.5


@pytest.mark.parametrize("noise", [0.0, 1e-5])
def test_log_without_motion(emps, rigid_log, noise: float) -> None:
    log = rigid_log(emps, np.zeros((3, 8000, 1)), noise=noise)
    with pytest.raises(InputError, match="still: all torques are zero.*no motor moves beyond the noise of its encoder"):
        fit_rigid(log, emps, SLOW, "still")


def test_log_without_torque(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(8000, 1e-3, 1))
    log.joint_commands.effort[:] = 0.0
    with pytest.raises(InputError, match="idle: all torques are zero"):
        fit_rigid(log, emps, SLOW, "idle")


def test_torque_of_zero_throughout_is_no_error_of_a_motor(fourier_motion, rigid_log) -> None:
    robot = load_robot("e12")
    motion = fourier_motion(8000, 1e-3, 2)
    log = rigid_log(robot, motion)
    log.joint_commands.effort[:, 1] = 0.0
    assert np.isnan(fit_rigid(log, robot, SLOW).error.motors[1])


def test_log_that_is_too_short(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(2500, 1e-3, 1))
    with pytest.raises(InputError, match="samples are left after filtering and decimation, but 4 parameters need"):
        fit_rigid(log, emps, RigidSettings(cutoff=20.0))


@pytest.mark.slow
def test_long_logs_are_taken_in_parts(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(45_000, 1e-3, 1), friction=friction)
    shares: list[float] = []
    fit = fit_rigid(log, emps, RigidSettings(cutoff=100.0), progress=shares.append)
    assert fit.error.rows == 4480
    assert len(shares) > 10
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    np.testing.assert_allclose(fit.values, truth(fit), rtol=1e-3)


@pytest.mark.slow
@NEEDS_EMPS
def test_measured_drive_gives_the_published_values(emps) -> None:
    """Janot, Gautier and Brunot (2019): M, Fv, Fc and relative force errors, symmetric and asymmetric."""
    folder, mapping = Path(REALDATA) / "emps", load_mapping("emps")
    log, pulses = (import_log(mapping, [folder / name]) for name in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"))
    fit = fit_rigid(log, emps)
    values = dict(zip(fit.base.names, fit.values, strict=True))
    assert values["body_1.mass"] == pytest.approx(95.1089, rel=0.02)
    assert values["motor_1.viscous_friction"] == pytest.approx(203.5034, rel=0.02)
    assert values["motor_1.coulomb_friction"] == pytest.approx(20.3935, rel=0.02)
    assert values["motor_1.torque_offset"] == pytest.approx(-3.1648, rel=0.02)
    assert fit.error.total == pytest.approx(4.0834, abs=0.2)
    assert cross_test(fit, pulses).total == pytest.approx(5.9824, abs=0.2)
    asymmetric = fit_rigid(log, emps, RigidSettings(asymmetric=True))
    published = [95.1540, 166.7061, 20.1440, 240.4236, 20.6277]
    np.testing.assert_allclose(asymmetric.values, published, rtol=0.02)
    assert asymmetric.error.total == pytest.approx(3.1117, abs=0.2)
