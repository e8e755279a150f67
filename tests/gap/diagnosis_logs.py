"""Short logs of the diagnosis experiment, and what a search needs of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache

import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.candidate import Candidate, FreeParameter, Hypothesis, list_candidates
from flexros.gap.candidates.scales import Scales
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData, fit_data
from flexros.gap.search import candidate_fits as search
from flexros.gap.search.candidate_fits import Search
from flexros.gap.settings import DiagnosisSettings
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.robot import Robot, load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

ROBOT = load_robot("four_mass_linear")
MODEL = RobotWithEffects(ROBOT, ())
SECONDS = 12.0
FEW = ("coulomb_friction", "viscous_friction", "stiffness_error", "motor_inertia_error", "torque_bias", "backlash")


@cache
def record_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> Record:
    """Simulate the diagnosis experiment with effects in the plant; `length` of its motion [s]."""
    keys = {"robot": ROBOT.name, "diagnosis.length": length, "seed": seed, "plant.effects": list(effects)}
    scenario = load_scenario("diagnosis").with_values(keys, "test")
    record = read_record(closed_loop(Experiment.prepare(scenario)), ROBOT, name="log")
    return record if tool else replace(record, tool=None)


@cache
def data_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> FitData:
    """Weigh such a log."""
    return fit_data(record_of(*effects, length=length, seed=seed, tool=tool), MODEL, DiagnosisSettings())


def search_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> Search:
    """Prepare a search in such a log."""
    return Search(MODEL, data_of(*effects, length=length, seed=seed, tool=tool), threads=1)


@cache
def candidates_of(*effects: str) -> dict[str, Candidate]:
    """List what may be the cause of such a log, by effect@place."""
    search = search_of(*effects)
    nothing = search.nothing()
    return {one.name: one for one in list_candidates(ROBOT, search.scales(nothing))}


def predictor_of(
    *hypothesis: Candidate, tolerance: Tolerance | None = None, model: RobotWithEffects = MODEL
) -> Predictor:
    """Build a predictor for such logs."""
    placed: Hypothesis = hypothesis
    return Predictor(model, placed, tolerance or Tolerance(), ROBOT.sample_time)


def numbers(candidate: Candidate, **values: float) -> list[float]:
    """Encode values of the free parameters of a candidate."""
    free: dict[str, FreeParameter] = {one.name: one for one in candidate.free}
    assert set(free) == set(values)
    return [one.encode(values[name]) for name, one in free.items()]


@contextmanager
def few_candidates() -> Iterator[None]:
    """Look for some effects only, which makes searches for several of them short."""

    def some(robot: Robot, sizes: Scales) -> tuple[Candidate, ...]:
        return tuple(one for one in list_candidates(robot, sizes) if one.effect.name in FEW)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "list_candidates", some)
        patch.setattr(search, "harmonic_candidates", lambda *_: ())
        yield
