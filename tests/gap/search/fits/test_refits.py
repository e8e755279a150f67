"""Refits of an explanation: what a comparison of two of them must not depend on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings
from flexros.record.read import read_record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.gap.diagnosis_logs import settings_of

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("name", "level", "usual", "kept"), [("elbow", 100.0, 3, 5), ("emps", 20.0, 1, 1)])
def test_an_effect_of_no_size_does_not_gain_by_its_finer_steps(name: str, level: float, usual: int, kept: int) -> None:
    """At 250 Hz it takes five steps per sample; friction alone takes fewer, which matters behind the springs of one."""
    robot = load_robot(name)
    model, friction, mode = RobotWithEffects(robot, ()), "coulomb_friction@motor_1", "extra_mode@tool"
    keys = {"robot": name, "diagnosis.length": 12.0, "seed": 1, "sample_time": 0.004}
    scenario = load_scenario("diagnosis").with_values({**keys, "plant.effects": [f"{friction}:level={level}"]}, "test")
    record = read_record(closed_loop(Experiment.prepare(scenario)), robot, name="log").part(0, 2000)
    data = fit_data(replace(record, tool=None), model, DiagnosisSettings())
    search = prepare_search(fit_null(data, model, Tolerance()), settings_of())
    both = tuple(one for one in search.candidates() if one.name in (friction, mode))
    predictor = search.null.predictor(both)
    sizes = {"level": level, "frequency": 20.0, "damping": 0.05, "ratio": 1e-6, "inertia_ratio": 1e-6}
    theta = np.array([free.encode(sizes[free.name]) for one in both for free in one.free])
    fit = search.completed(CandidateFit(predictor, theta, np.inf))
    rest = search.without(fit, mode)
    assert (search.null.predictor(rest.hypothesis).plant.steps.number, predictor.plant.steps.number) == (usual, 5)
    assert rest.predictor.plant.steps.number == kept
    assert search.completed(rest).predictor.plant.steps.number == kept
    assert rest.chi2 - fit.chi2 < np.log(data.n_values)
