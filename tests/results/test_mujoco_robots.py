"""Arms of MuJoCo with hidden effects: what their logs show, by the programs of the results page."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from flexros.effects import PlacedEffect, RobotWithEffects
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.gear.stiffness_error import StiffnessError
from flexros.effects.patching.patched_robot import load_model
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.torques.noted_timing import with_torque_in_time_behind_springs
from flexros.gap.measure_gap import measure_gap
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.torque_start import TorqueStart, torque_start
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.record.record import Record

pytest.importorskip("mujoco", reason="MuJoCo is not installed")

PROGRAMS = Path(__file__).parents[2] / "docs" / "results" / "programs" / "simulated"
DURATION = 6.0


@pytest.fixture(scope="module", autouse=True)
def found_programs() -> Iterator[None]:
    sys.path.insert(0, str(PROGRAMS))
    yield
    sys.path.remove(str(PROGRAMS))


def program(name: str) -> ModuleType:
    return importlib.import_module(f"mujoco_robots_{name}")


def recorded(arm: Any, truth: Any, folder: Path, seed: int = 1) -> tuple[RobotWithEffects, Record]:
    """Return the nominal model of an arm and a log of the true one."""
    made, model = program("truth"), load_model(arm.robot)
    mapping, table = made.write_log(arm, truth, made.run(arm, truth, seed, DURATION), folder, f"log_{seed}")
    log = import_log(load_mapping(str(mapping)), [table])
    return model, checked_log(log, model.robot, name="log")


def started(nominal: RobotWithEffects, record: Record) -> TorqueStart:
    model = nominal.commanded_by(record.commands)
    settings = DiagnosisSettings()
    start = torque_start(fit_data(record, model, settings), model, tolerance_of(model.robot, {}), settings)
    assert start is not None
    return start


def test_rotors_on_bodies_of_their_own_are_motors_with_elastic_gears(tmp_path: Path) -> None:
    """MuJoCo wants mass on every moving body."""
    arm = program("arms").drawn_arm(1, tmp_path, elastic=True)
    robot = load_model(arm.robot).robot
    assert len(robot.flexible_motors) == robot.n_motors == arm.n_motors
    assert robot.n_coordinates == 2 * arm.n_motors


@pytest.mark.slow
@pytest.mark.parametrize("noted", [0, 1])
def test_when_a_measured_torque_acted_is_seen_through_elastic_gears(noted: int, tmp_path: Path) -> None:
    arm = program("arms").drawn_arm(2, tmp_path, elastic=True)
    model, record = recorded(arm, program("truth").Truth({}, measured=True, noted=noted), tmp_path)
    assert with_torque_in_time_behind_springs(record, model.robot).torque_shift == (-0.5 if noted else 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("noted", [0, 1])
def test_half_a_sample_that_a_wrong_spring_hides_shows_once_the_spring_is_right(noted: int, tmp_path: Path) -> None:
    """Of the gap with the right spring most would be that half sample."""
    causes = {("stiffness_error", "motor_2"): 0.6, ("coulomb_friction", "motor_1"): 1.0}
    arm = program("arms").drawn_arm(2, tmp_path, elastic=True)
    truth = program("truth").Truth(causes, measured=True, noted=noted)
    model, record = recorded(arm, truth, tmp_path)
    effects = [
        PlacedEffect(StiffnessError(relative=0.6), model.robot.motors[1].joint.name),
        PlacedEffect(CoulombFriction(level=1.0), "motor_1"),
    ]
    right = measure_gap(record, model, repaired=model.with_effects(effects))
    assert any("half a sample" in warning for warning in right.warnings)
    assert right.numbers.after is not None
    assert right.numbers.after < 0.2


@pytest.mark.slow
def test_search_is_repeated_with_torques_in_time_once_the_spring_is_right(tmp_path: Path) -> None:
    causes = {("stiffness_error", "motor_2"): 0.6, ("coulomb_friction", "motor_1"): 1.0}
    arm = program("arms").drawn_arm(2, tmp_path, elastic=True)
    truth = program("truth").Truth(causes, measured=True, noted=1)
    (model, fitted), (_, held) = (recorded(arm, truth, tmp_path, seed) for seed in (1, 2))
    search = SearchSettings(effects=("coulomb_friction", "viscous_friction", "stiffness_error", "backlash", "delay"))
    settings = DiagnosisSettings(where=None, next_experiment=None, time_limit=3600.0, search=search)
    result = diagnose(fitted, model, holdout=held, settings=settings)
    found = result.diagnosis
    assert result.settings.time_limit == 3600.0
    assert any("since the one before, half a sample" in warning for warning in found.warnings)
    named = {f"{cause.effect}@{cause.location}" for cause in found.causes if cause.probability > 0.5}
    assert named == {"coulomb_friction@motor_1", f"stiffness_error@{model.robot.motors[1].joint.name}"}


def test_search_of_a_servo_log_begins_with_gains_friction_and_delay(tmp_path: Path) -> None:
    causes = {
        ("servo_stiffness_error", "motor_1"): -0.3,
        ("coulomb_friction", "motor_2"): 0.25,
        ("motor_inertia_error", "motor_2"): 0.4,
    }
    arm = program("arms").drawn_arm(5, tmp_path, drive="servo")
    start = started(*recorded(arm, program("truth").Truth(causes, delay=2), tmp_path))
    assert start.delay == pytest.approx(2 / program("truth").RATE)
    found = {candidate.name: size for candidate, (size,) in start.hypothesis()}
    assert found["servo_stiffness_error@motor_1"] == pytest.approx(-0.3, abs=0.05)
    assert found["coulomb_friction@motor_2"] == pytest.approx(0.25, rel=0.1)
    assert found["motor_inertia_error@motor_2"] == pytest.approx(0.4, abs=0.06)
    assert found["delay@all"] == start.delay


@pytest.mark.slow
def test_a_delay_of_five_samples_is_found_and_its_patch_closes_the_gap_of_measured_torques(tmp_path: Path) -> None:
    arm = program("arms").drawn_arm(2, tmp_path)
    truth = program("truth").Truth({}, delay=5, measured=True)
    (model, fitted), (_, held) = (recorded(arm, truth, tmp_path, seed) for seed in (1, 2))
    late = ("delay", "actuator_lag", "coulomb_friction", "viscous_friction", "torque_gain_error", "motor_inertia_error")
    settings = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=late))
    found = diagnose(fitted, model, holdout=held, settings=settings).diagnosis
    assert [f"{cause.effect}@{cause.location}" for cause in found.causes] == ["delay@all"]
    assert found.causes[0].parameters["time"].value == pytest.approx(truth.late, rel=0.02)
    assert found.verdict == "explained"


def test_late_measured_torques_are_late_from_the_middle_of_their_sample() -> None:
    truth, period = program("truth").Truth, 1 / program("truth").RATE
    assert truth({}, delay=3).late == pytest.approx(3 * period)
    assert truth({}, sensor_delay=1, measured=True).late == pytest.approx(1.5 * period)
    assert truth({}, delay=1, measured=True, noted=1).late == 0.0


def test_drawn_cases_differ_by_their_seed_alone(tmp_path: Path) -> None:
    arms, truths = program("arms"), program("truth")
    for name in ("one", "two", "three"):
        (tmp_path / name).mkdir()
    one, two = (arms.drawn_arm(7, tmp_path / name) for name in ("one", "two"))
    assert one.base.read_text() == two.base.read_text()
    assert truths.drawn_truth(one, "torque", 7) == truths.drawn_truth(two, "torque", 7)
    assert arms.drawn_arm(8, tmp_path / "three").base.read_text() != one.base.read_text()
    np.testing.assert_array_equal(truths.reference(one, 3, 2.0), truths.reference(two, 3, 2.0))


def test_a_rotor_has_the_inertia_of_the_truth_beside_damping(tmp_path: Path) -> None:
    """v = torque / D (1 - exp(-D t / J)); a step implicit in the damping alone would have half of it times D more."""
    import mujoco

    damping, torque = 2.0, 0.1
    arm = program("arms").arm_of_urdf(PROGRAMS.parents[2] / "examples" / "ur5e.urdf", tmp_path)
    rotors = {f"motor_{k}": 1e6 for k in range(1, 6)} | {"motor_6": 0.05}

    def pushed(causes: dict[tuple[str, str], float]) -> tuple[Any, Any]:
        model = program("truth").true_model(arm, program("truth").Truth(causes, rotors))
        model.opt.gravity[:], data = 0.0, mujoco.MjData(model)
        data.qfrc_applied[5] = torque
        mujoco.mj_forward(model, data)
        return model, data

    _, free = pushed({})
    J = torque / free.qacc[5]
    model, data = pushed({("viscous_friction", "motor_6"): damping})
    mujoco.mj_step(model, data, round(J / damping / model.opt.timestep))
    expected = torque / damping * -np.expm1(-damping * data.time / J)
    assert data.qvel[5] == pytest.approx(expected, rel=3e-4)
