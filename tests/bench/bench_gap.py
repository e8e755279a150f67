"""Time and memory of a diagnosis of a log of 40 s, at 2 kHz and as arms are recorded: all effects at all locations.

Prints a JSON list of rows. The log is that of the diagnosis experiment; the plant has friction that the model does not
contain, and a row reports whether the verdict names it. Every robot is diagnosed in a process of its own, whose peak
memory is reported. The peer of the prediction pass is the same predictor with one set of parameters at a time.

`python -m tests.bench.bench_gap ROBOT` measures one robot only; six_axis takes minutes. `--limits` measures how long
after a time limit the result of a crowd of effects on `elbow` is there, with its report.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.compile.loop.prediction import PredictionLoop
from flexros.effects import RobotWithEffects, effects
from flexros.effects.kinds.law import AbstractLaw
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.held_out.split import split
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.report.files import write_diagnosis
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros.simulate.open_loop import feed_through
from tests.bench.bench_simulate import row, seconds

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.record.record import Record
    from flexros.robot import Robot

HIDDEN = {"four_mass_linear": 0.05, "e12": 0.5, "six_axis": 2.0}
"""Coulomb friction of the first motor of the plant, by robot [N or Nm]."""
GOAL_S = {("four_mass_linear", 2000): 10.0, ("e12", 2000): 20.0, ("six_axis", 2000): 150.0, ("six_axis", 250): 60.0}
"""Goals for a diagnosis by robot and sampling rate [s]."""
GOAL_GB = 1.5
LENGTH = 40.0
RUN_ALONE, LIMITED = "--alone", "--limits"
CROWD = (
    "coulomb_friction@motor_1:level=0.5",
    "viscous_friction@motor_2:coefficient=0.01",
    "stiffness_error@body_2.ry:relative=-0.08",
    "motor_inertia_error@motor_1:relative=0.1",
    "backlash@motor_2:gap=0.001",
)
"""Effects of `elbow` whose search takes longer than the limits."""
LIMITS_S = (5.0, 10.0, 20.0, 30.0)


def log_of(robot: Robot, *effects: str, rate: int = 2000) -> Record:
    """Record the diagnosis experiment, without disk; default: with friction at the first motor."""
    hidden = effects or (f"coulomb_friction@{robot.joint_names[0]}:level={HIDDEN[robot.name]}",)
    keys = {"robot": robot.name, "seed": 1, "diagnosis.length": LENGTH, "plant.effects": list(hidden)}
    scenario = load_scenario("diagnosis").with_values({**keys, "sample_time": 1 / rate})
    return checked_log(closed_loop(Experiment.prepare(scenario)), robot, name="log")


def diagnosis_rows(robot: Robot, rate: int) -> Iterator[dict[str, Any]]:
    """Diagnose once, in this process, which must not have done anything else."""
    record = log_of(robot, rate=rate)
    wall, processor = time.perf_counter(), time.process_time()
    found = diagnose(record, robot).diagnosis
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    named = found.verdict == "explained" and [(cause.effect, cause.location) for cause in found.causes[:1]] == [
        ("coulomb_friction", robot.joint_names[0])
    ]
    case = f"{robot.name}, {record.n_samples} samples at {rate} Hz"
    yield row(case, "diagnosis", wall, "s", GOAL_S[robot.name, rate])
    yield row(case, "diagnosis, processor time", processor, "s")
    yield row(case, "largest memory", memory / 1e9, "GB", GOAL_GB)
    yield row(case, "verdict names the hidden effect alone (1: yes)", float(named), "1", 1.0)


def limit_rows(robot: Robot) -> Iterator[dict[str, Any]]:
    """Measure how long after a time limit the files of a partial diagnosis are there."""
    record = log_of(robot, *CROWD)
    for limit in LIMITS_S:
        begin, used = time.perf_counter(), time.process_time()
        result = diagnose(record, robot, settings=DiagnosisSettings(time_limit=limit))
        with TemporaryDirectory() as folder:
            write_diagnosis(result, robot.name, Path(folder) / "diagnosis")
        late, used = time.perf_counter() - begin - limit, time.process_time() - used
        case, closed = f"{robot.name}, limit of {limit:g} s", result.diagnosis.gap.closed_fraction
        yield row(case, "files are there after the limit", late, "s", limit / 4 + 10)
        yield row(case, "processor time of all", used, "s")
        yield row(case, "ended by its limit (1: yes)", float(result.diagnosis.partial is not None), "1")
        yield row(case, "effects found", len(result.patch), "1")
        yield row(case, "share of the gap closed on held-out data", closed or 0.0, "1")


def pass_rows(robot: Robot) -> Iterator[dict[str, Any]]:
    """Time predictions of the part of the log that is fitted to, with friction as the suspected effect."""
    settings = DiagnosisSettings()
    record, _ = split(replace(log_of(robot), tool=None), settings.fitted_share)
    model = RobotWithEffects(robot, ())
    data = fit_data(record, model, settings)
    level = HIDDEN[robot.name]
    free = FreeParameter("level", 0.1 * level, 10 * level, signed=False, starts=(level,))
    candidate = Candidate(effects()["coulomb_friction"], robot.joint_names[0], (free,))
    predictor = Predictor(model, (candidate,), Tolerance(), record.sample_time)
    thetas = np.array([[free.encode(level * factor) for factor in np.linspace(0.5, 1.5, LANES)]])
    case = f"{robot.name}, {data.record.n_samples} samples"
    took = seconds(lambda: predictor.predict(thetas, data.record, data.gain, data.initial_state), 10)
    yield row(case, f"prediction pass of {LANES} lanes", 1e3 * took, "ms")
    yield row(case, "the same per sample and lane", 1e9 * took / (data.record.n_samples * LANES), "ns")

    functions = predictor.model.functions(feed_through(robot.n_motors))
    loop = PredictionLoop(functions, sample_time=record.sample_time, delay=predictor.model.delay, lanes=1)
    columns = [np.array(parameters_of(candidate, float(level_of_lane))) for level_of_lane in np.exp(thetas[0])]
    start = predictor.model.start(data.initial_state, record.torque[0], columns[0])
    gain = np.zeros((loop.sizes.state, robot.n_motors))
    gain[: len(data.gain.gain)] = data.gain.gain
    valid = data.record.valid.astype(float)

    def one_by_one() -> None:
        for column in columns:
            loop.run(start, column[:, None], gain, data.record.torque, data.record.position, valid)

    yield row(case, f"{LANES} passes of one lane", 1e3 * seconds(one_by_one, 10), "ms")


def parameters_of(candidate: Candidate, level: float) -> list[float]:
    """List the parameters of the plant with friction of this level."""
    law = candidate.placed({"level": level}).effect
    assert isinstance(law, AbstractLaw)
    return list(law.parameter_values.values())


def diagnosed_apart(name: str, rate: int) -> list[dict[str, Any]]:
    """Diagnose in a process of its own."""
    command = [sys.executable, "-m", "tests.bench.bench_gap", RUN_ALONE, name, str(rate)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    rows: list[dict[str, Any]] = json.loads(done.stdout)
    return rows


def main(arguments: list[str]) -> None:
    """Print all rows, or those of the robots given, as one JSON list."""
    rows: list[dict[str, Any]] = []
    if arguments[:1] == [RUN_ALONE]:
        rows += diagnosis_rows(load_robot(arguments[1]), int(arguments[2]))
    elif arguments[:1] == [LIMITED]:
        rows += limit_rows(load_robot("elbow"))
    else:
        for name in arguments or list(HIDDEN):
            rows += pass_rows(load_robot(name))
            for rate in (rate for robot, rate in GOAL_S if robot == name):
                rows += diagnosed_apart(name, rate)
    print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main(sys.argv[1:])
