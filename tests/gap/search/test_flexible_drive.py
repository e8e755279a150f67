"""A measured drive with friction beside a wrong spring, or that yields: each hides behind another effect at first."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.diagnose import diagnose
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.random_streams import generator
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.simulate.plant import Plant

pytestmark = pytest.mark.slow

FRICTION = ("coulomb_friction@motor_1:level=6", "viscous_friction@motor_1:coefficient=10")
N = 12_000
RIVALS = (
    *("coulomb_friction", "viscous_friction", "stribeck_friction", "presliding_friction", "hysteresis"),
    *("backlash", "stiffness_error"),
    *("nonlinear_stiffness", "damping_error", "motor_inertia_error", "torque_gain_error", "payload_error"),
)
"""Friction, springs, and numbers of the drive."""
SETTINGS = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=RIVALS))


@cache
def record_of(*effects: str) -> Record:
    """Drive a motor by sines and a slow position loop, and record it as another program would."""
    robot = load_robot("two_mass")
    T = robot.sample_time
    placed = place_effects(robot, [parse_effect(text, "test") for text in effects])
    random, time, drive = generator(1, 600), T * np.arange(N), np.zeros(N)
    for frequency in np.arange(1.3, 30, 1.7):
        drive += 30 * np.sin(2 * np.pi * frequency * time + random.uniform(0, 2 * np.pi))
    plant = Plant(placed.robot, T, np.zeros(4), substeps=4, laws=placed.laws)
    position, torque = np.zeros((N, 1)), np.zeros((N, 1))
    for k in range(N):
        state = plant.state
        position[k] = state[1]
        torque[k] = drive[k] + 200 * (0.5 * np.sin(2 * np.pi * 0.4 * time[k]) - state[1]) - 20 * state[3]
        plant.advance(torque[k])
    position += 1e-5 * random.standard_normal(position.shape)
    return Record("log", T, position, torque, np.ones(N, dtype=bool), imported=True)


@pytest.mark.parametrize(
    ("effect", "size"),
    [
        ("stiffness_error@body_1.rz:relative=-0.3", "relative"),
        ("nonlinear_stiffness@body_1.rz:relative=-0.5,knee=1e-3", "relative"),
    ],
)
def test_friction_that_drowned_in_a_wrong_spring_is_found_beside_it(effect: str, size: str) -> None:
    robot = RobotWithEffects(load_robot("two_mass"), ())
    found = diagnose(record_of(*FRICTION, effect), robot, settings=SETTINGS)
    causes = {f"{one.effect}@{one.location}": one for one in found.diagnosis.causes}
    name = effect.partition(":")[0]
    assert causes.keys() == {"coulomb_friction@motor_1", "viscous_friction@motor_1", name}
    assert causes["coulomb_friction@motor_1"].parameters["level"].value == pytest.approx(6, rel=0.05)
    assert causes["viscous_friction@motor_1"].parameters["coefficient"].value == pytest.approx(10, rel=0.05)
    spring = causes[name].parameters[size]
    assert spring.value == pytest.approx(float(effect.partition(f"{size}=")[2].partition(",")[0]), rel=0.05)
    assert found.diagnosis.verdict == "explained"


def test_friction_that_yields_before_it_slides_is_not_taken_for_a_rigid_one() -> None:
    """It bends by 1 mrad. Rigid friction does most of that, so that no other law comes in its place at first."""
    yields = "presliding_friction@motor_1:level=20,stiffness=2e4,damping=6"
    found = diagnose(record_of(yields, FRICTION[1]), RobotWithEffects(load_robot("two_mass"), ()), settings=SETTINGS)
    causes = {f"{one.effect}@{one.location}": one for one in found.diagnosis.causes}
    assert causes.keys() == {"presliding_friction@motor_1", "viscous_friction@motor_1"}
    friction = causes["presliding_friction@motor_1"].parameters
    assert friction["level"].value == pytest.approx(20, rel=0.05)
    assert friction["stiffness"].value == pytest.approx(2e4, rel=0.1)
