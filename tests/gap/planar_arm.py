"""A measured arm of three vertical axes, which no gravity loads."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.random_streams import generator
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.simulate.plant import Plant

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.fits.candidate_fits import Search

LINK = """
  - mass: {mass}
    center_of_mass: [0.15, 0, 0]
    inertia: {{zz: 0.05}}
    length: [0.3, 0, 0]
    directions: {{rz: {{spring: rigid, motor: {{inertia: {rotor}}}}}}}"""
ARM = """name: planar arm
gravity: [0, 0, -9.81]
sample_time: 0.002
bodies:{links}
outputs: {{joints: {{coordinates: [body_1.rz, body_2.rz, body_3.rz]}}}}
controlled: joints
"""
FRICTION = tuple(f"coulomb_friction@motor_{k}:level={level}" for k, level in ((1, 1.5), (2, 0.8), (3, 0.4)))
SAMPLES = 5000
RIVALS = ("coulomb_friction", "torque_gain_error", "torque_bias")
SETTINGS = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=RIVALS))


@cache
def arm_file(folder: Path) -> str:
    """Write an arm of three vertical axes, which no gravity loads."""
    links = "".join(LINK.format(mass=mass, rotor=rotor) for mass, rotor in ((5, 0.2), (3, 0.1), (1.5, 0.03)))
    (folder / "arm.yaml").write_text(ARM.format(links=links), encoding="utf-8")
    return str(folder / "arm.yaml")


def log_of(folder: Path, *truth: str, seed: int = 3) -> FitData:
    """Let a slow loop track sines as a measured arm would.

    Args:
        folder: Where the file of the robot is written.
        truth: Effects in the plant.
        seed: Seed of the noise and of the phases of the sines.
    """
    robot = load_robot(arm_file(folder))
    placed, T = place_effects(robot, [parse_effect(text, "test") for text in truth]), robot.sample_time
    random, time = generator(seed, 600), T * np.arange(SAMPLES)
    phases = random.uniform(0, 2 * np.pi, 3)
    target = 0.6 * np.sin(2 * np.pi * np.outer(time, [0.4, 0.7, 1.1]) + phases)
    plant = Plant(placed.robot, T, np.zeros(6), substeps=4, laws=placed.laws)
    position, torque = np.zeros((SAMPLES, 3)), np.zeros((SAMPLES, 3))
    for k in range(SAMPLES):
        position[k], speed = plant.state[:3], plant.state[3:]
        torque[k] = np.array([200, 80, 20]) * (target[k] - position[k]) - np.array([20, 8, 2]) * speed
        plant.advance(torque[k])
    position += 2e-5 * random.standard_normal(position.shape)
    record = Record("log", T, position, torque, np.ones(SAMPLES, dtype=bool), imported=True)
    return fit_data(record, RobotWithEffects(robot, ()), SETTINGS)


def searched(folder: Path, *truth: str) -> Search:
    """Prepare a search in such a log, with an arm that is known to 5 %."""
    data = log_of(folder, *truth)
    model = RobotWithEffects(load_robot(arm_file(folder)), ())
    return prepare_search(fit_null(data, model, tolerance_of(model.robot, {"inertia": 0.05})), SETTINGS)


def candidates_named(search: Search, *names: str) -> tuple[Candidate, ...]:
    """Return the candidates of these names."""
    known = {one.name: one for one in search.candidates()}
    return tuple(known[name] for name in names)
