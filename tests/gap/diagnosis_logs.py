"""Short logs of the diagnosis experiment, and what a search needs of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.candidate import Candidate, FreeParameter, Hypothesis, list_candidates
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings, SearchSettings, WhereSettings
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

ROBOT = load_robot("four_mass_linear")
MODEL = RobotWithEffects(ROBOT, ())
SECONDS = 8.0
"""How much of the diagnosis experiment the logs contain: rest, creep and a multisine or fast moves [s]."""
WHOLE = 20.0
"""More than it has: for what needs all of it, as waves in the rotor angle and noise that is known well [s]."""
FEW_EFFECTS = (
    "coulomb_friction",
    "viscous_friction",
    "stiffness_error",
    "motor_inertia_error",
    "torque_bias",
    "backlash",
)


@cache
def record_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> Record:
    """Simulate a short diagnosis experiment with effects in the plant; return its first `length` seconds."""
    keys = {"robot": ROBOT.name, "diagnosis.length": 12.0, "seed": seed, "plant.effects": list(effects)}
    scenario = load_scenario("diagnosis").with_values(keys, "test")
    record = read_record(closed_loop(Experiment.prepare(scenario)), ROBOT, name="log")
    record = record.part(0, min(record.n_samples, round(length / record.sample_time)))
    return record if tool else replace(record, tool=None)


@cache
def data_of(*effects: str, length: float = SECONDS, seed: int = 1, tool: bool = False) -> FitData:
    """Weigh such a log."""
    return fit_data(record_of(*effects, length=length, seed=seed, tool=tool), MODEL, DiagnosisSettings())


def settings_of(*effects: str, where: WhereSettings | None = None) -> DiagnosisSettings:
    """Settings of a short diagnosis, in which these effects compete, or all."""
    return DiagnosisSettings(threads=1, where=where, next_experiment=None, search=SearchSettings(effects=effects))


def search_of(
    *effects: str, among: tuple[str, ...] = (), tolerance: Tolerance | None = None, length: float = SECONDS
) -> Search:
    """Prepare a search in such a log, in which some effects compete, or all."""
    data = data_of(*effects, length=length)
    return prepare_search(fit_null(data, MODEL, tolerance or Tolerance()), settings_of(*among))


@cache
def candidates_of(*effects: str) -> dict[str, Candidate]:
    """List the candidates of such a log by effect@location."""
    return {candidate.name: candidate for candidate in list_candidates(ROBOT, search_of(*effects).scales)}


def predictor_of(
    *hypothesis: Candidate, tolerance: Tolerance | None = None, model: RobotWithEffects = MODEL
) -> Predictor:
    """Build a predictor for such logs."""
    placed: Hypothesis = hypothesis
    return Predictor(model, placed, tolerance or Tolerance(), ROBOT.sample_time)


def encoded(candidate: Candidate, **values: float) -> list[float]:
    """Convert values of the free parameters of a candidate to the units of the fit."""
    free: dict[str, FreeParameter] = {one.name: one for one in candidate.free}
    assert set(free) == set(values)
    return [one.encode(values[name]) for name, one in free.items()]
