"""Short logs of the diagnosis experiment, and what a search needs of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache

import pytest

from flexros.config.scenario import load_scenario
from flexros.effects import RobotWithEffects
from flexros.gap import search
from flexros.gap.fit_data import FitData, fit_data
from flexros.gap.hypothesis import FreeParameter, Hypothesis, Suspect, suspects
from flexros.gap.predictor import Predictor
from flexros.gap.read_record import read_record
from flexros.gap.record import GapRecord
from flexros.gap.search import Search
from flexros.gap.settings import DiagnosisSettings
from flexros.gap.tolerance import Tolerance
from flexros.gap.yardsticks import Yardsticks
from flexros.robot import Robot, load_robot
from flexros.simulate.closed_loop import closed_loop
from flexros.simulate.experiment import Experiment

ROBOT = load_robot("four_mass_linear")
MODEL = RobotWithEffects(ROBOT, ())
SECONDS = 12.0
FEW = ("coulomb_friction", "viscous_friction", "stiffness_error", "motor_inertia_error", "torque_bias", "backlash")


@cache
def record_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> GapRecord:
    """Simulate the diagnosis experiment with effects in the plant; `length` of its motion [s]."""
    keys = {"robot": ROBOT.name, "diagnosis.length": length, "seed": seed, "plant.effects": list(effects)}
    scenario = load_scenario("diagnosis").with_values(keys, "test")
    record = read_record(closed_loop(Experiment.prepare(scenario)), ROBOT, name="log", check=False)
    return record if tool else replace(record, tool=None)


@cache
def data_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> FitData:
    """Weigh such a log."""
    return fit_data(record_of(*effects, length=length, seed=seed, tool=tool), MODEL, DiagnosisSettings())


def search_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> Search:
    """Prepare a search in such a log."""
    return Search(MODEL, data_of(*effects, length=length, seed=seed, tool=tool), threads=1)


@cache
def suspects_of(*effects: str) -> dict[str, Suspect]:
    """List what may be the cause of such a log, by effect@place."""
    search = search_of(*effects)
    nothing = search.nothing()
    return {one.name: one for one in suspects(ROBOT, search.yardsticks(nothing))}


def predictor_of(
    *hypothesis: Suspect, tolerance: Tolerance | None = None, model: RobotWithEffects = MODEL
) -> Predictor:
    """Build a predictor for such logs."""
    placed: Hypothesis = hypothesis
    return Predictor(model, placed, tolerance or Tolerance(), ROBOT.sample_time)


def numbers(suspect: Suspect, **values: float) -> list[float]:
    """Encode values of the free parameters of a suspect."""
    free: dict[str, FreeParameter] = {one.name: one for one in suspect.free}
    assert set(free) == set(values)
    return [one.encode(values[name]) for name, one in free.items()]


@contextmanager
def few_suspects() -> Iterator[None]:
    """Look for some effects only, which makes searches for several of them short."""

    def some(robot: Robot, sizes: Yardsticks) -> tuple[Suspect, ...]:
        return tuple(one for one in suspects(robot, sizes) if one.effect.name in FEW)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "suspects", some)
        patch.setattr(search, "periodic_suspects", lambda *_: ())
        yield
