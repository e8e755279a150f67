"""Refits of an explanation: what a comparison of two of them must not depend on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.fits import refits
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings
from flexros.record.read import read_record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.gap.diagnosis_logs import search_of, settings_of

pytestmark = pytest.mark.slow


def counted_sets(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Count the sets of parameters that are predicted from now on, in the last number of a list."""
    sets, residuals = [0], FitData.residuals

    def counted(self: FitData, predictor: Predictor, thetas: FloatArray) -> FloatArray:
        sets[-1] += thetas.shape[1]
        return residuals(self, predictor, thetas)

    monkeypatch.setattr(FitData, "residuals", counted)
    return sets


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


def test_a_fit_without_an_effect_holds_the_slopes_around_the_explanation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where these are known it takes fewer predictions, and ends as near to the minimum."""
    tolerance = Tolerance(("body_1.rz.stiffness", "motor_1.inertia"), (0.3, 0.3))
    search = search_of("coulomb_friction@motor_1:level=0.3", tolerance=tolerance)
    kept, left_out = "coulomb_friction@motor_1", "viscous_friction@motor_1"
    both = tuple(one for one in search.candidates() if one.name in (kept, left_out))
    start = np.array([free.encode(0.0 if free.signed else free.starts[0]) for one in both for free in one.free])
    predictor = search.null.predictor(both)
    fit = search.completed(CandidateFit(predictor, np.concatenate([start, np.zeros(2)]), np.inf))
    sets = counted_sets(monkeypatch)
    alone = search.without(fit, left_out)
    search.surroundings(fit)
    sets.append(0)
    held = search.without(fit, left_out)
    assert sets[1] < 0.5 * sets[0]
    assert held.chi2 < alone.chi2 + 0.1


def test_further_effects_beside_noise_hold_the_slopes_around_the_explanation(monkeypatch: pytest.MonkeyPatch) -> None:
    """They move tolerated numbers hardly; beside an explanation that lacks much they would far."""
    tolerance = Tolerance(("body_1.rz.stiffness", "motor_1.inertia"), (0.3, 0.3))
    search = search_of("coulomb_friction@motor_1:level=0.3", tolerance=tolerance)
    friction = next(one for one in search.candidates() if one.name == "coulomb_friction@motor_1")
    start = np.array([friction.free[0].encode(0.3), *([0.0] * (len(friction.free) - 1)), 0.0, 0.0])
    fit = search.completed(CandidateFit(search.null.predictor((friction,)), start, np.inf))
    assert fit.chi2 < refits.NEAR * search.data.n_values
    further = [one for one in search.candidates() if one.name == "viscous_friction@motor_1"]
    (addition,) = search.additions(search.directions(further, fit), fit, search.surroundings(fit))
    sets = counted_sets(monkeypatch)
    held = search.together(fit, [addition])
    monkeypatch.setattr(refits, "NEAR", 0.0)
    sets.append(0)
    anew = search.together(fit, [addition])
    assert sets[0] < sets[1]
    assert held.chi2 < anew.chi2 + 0.1
