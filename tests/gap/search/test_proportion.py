"""Scales of all torques of an arm without gravity."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.proportion import other_scales
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.random_streams import generator
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.simulate.plant import Plant

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.gap.candidates.candidate import Candidate
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
GAINS = tuple(f"torque_gain_error@motor_{k}" for k in (1, 2, 3))
SAMPLES = 5000


@cache
def arm_file(folder: Path) -> str:
    """Write an arm of three vertical axes, which no gravity loads."""
    links = "".join(LINK.format(mass=mass, rotor=rotor) for mass, rotor in ((5, 0.2), (3, 0.1), (1.5, 0.03)))
    (folder / "arm.yaml").write_text(ARM.format(links=links), encoding="utf-8")
    return str(folder / "arm.yaml")


def searched(folder: Path, *truth: str) -> Search:
    """Let a slow loop track sines as a measured arm would, and prepare a search whose arm is known to 5 %."""
    robot = load_robot(arm_file(folder))
    placed, T = place_effects(robot, [parse_effect(text, "test") for text in truth]), robot.sample_time
    random, time = generator(3, 600), T * np.arange(SAMPLES)
    target = np.array([[0.6 * np.sin(2 * np.pi * f * t + p) for f, p in ((0.4, 0), (0.7, 1), (1.1, 2))] for t in time])
    plant = Plant(placed.robot, T, np.zeros(6), substeps=4, laws=placed.laws)
    position, torque = np.zeros((SAMPLES, 3)), np.zeros((SAMPLES, 3))
    for k in range(SAMPLES):
        position[k], speed = plant.state[:3], plant.state[3:]
        torque[k] = np.array([200, 80, 20]) * (target[k] - position[k]) - np.array([20, 8, 2]) * speed
        plant.advance(torque[k])
    position += 2e-5 * random.standard_normal(position.shape)
    record = Record("log", T, position, torque, np.ones(SAMPLES, dtype=bool), imported=True)
    rivals = ("coulomb_friction", "torque_gain_error", "torque_bias")
    settings = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=rivals))
    model = RobotWithEffects(robot, ())
    null = fit_null(fit_data(record, model, settings), model, tolerance_of(robot, {"inertia": 0.05}))
    return prepare_search(null, settings)


def fitted(search: Search, *names: str) -> tuple[Candidate, ...]:
    """Return the candidates of these names."""
    known = {one.name: one for one in search.candidates()}
    return tuple(known[name] for name in names)


def test_one_gain_takes_the_place_of_those_of_all_other_motors(tmp_path: Path) -> None:
    """A gain of the shoulder that was 8 % too small had been named as two too large ones, in an arm too heavy."""
    search = searched(tmp_path, *FRICTION, f"{GAINS[0]}:relative=-0.08")
    friction = tuple(one.partition(":")[0] for one in FRICTION)
    hypothesis = fitted(search, *friction, *GAINS[1:])
    predictor = search.null.predictor(hypothesis)
    sizes = [1.63, 0.87, 0.435, 0.087, 0.087]
    encoded = [one.free[0].encode(size) for one, size in zip(hypothesis, sizes, strict=True)]
    start = np.concatenate([encoded, np.zeros(predictor.tolerance.n_free)])
    wrong = search.completed(replace(search.null.fit, predictor=predictor, theta=start))
    (begun,) = other_scales(search, wrong)
    right = search.completed(begun)
    assert right.names == {*friction, GAINS[0]}
    assert right.chi2 < wrong.chi2
    found = dict(zip((one.name for one in right.hypothesis), right.predictor.values(right.theta), strict=True))
    assert found[GAINS[0]]["relative"] == pytest.approx(-0.08, abs=0.02)
    assert found[friction[0]]["level"] == pytest.approx(1.5, rel=0.05)


def test_more_gains_than_before_are_not_tried(tmp_path: Path) -> None:
    """One gain of three that is wrong is simpler than two that are."""
    search = searched(tmp_path, *FRICTION, f"{GAINS[0]}:relative=-0.08")
    hypothesis = fitted(search, GAINS[0])
    predictor = search.null.predictor(hypothesis)
    start = np.concatenate([[hypothesis[0].free[0].encode(-0.08)], np.zeros(predictor.tolerance.n_free)])
    assert not list(other_scales(search, replace(search.null.fit, predictor=predictor, theta=start)))
