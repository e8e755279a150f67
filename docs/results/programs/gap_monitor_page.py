"""Write gap_monitor.md: python docs/results/programs/gap_monitor_page.py nominal|detection|accepted|page [WORK].

`nominal`, `detection` and `accepted` append their results case by case to WORK/*.jsonl until all cases are done;
`page` writes the page. Seeds from 5000 on were not used in development.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from gap_monitor_text import page_text

from flexros.effects import parse_effect
from flexros.effects.patching.patched_robot import load_model
from flexros.monitor.calibration import calibrate
from flexros.monitor.gap_monitor import GapMonitor
from flexros.monitor.thresholds import LENGTHS, thresholds
from flexros.monitor.watch_log import watch_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.time_series import Log
    from flexros.monitor.calibration import Calibration
    from flexros.monitor.watch_log import WatchedLog

RATES = (1e-3, 1.0, 10.0, 100.0)
"""Rates of false alarms whose thresholds are evaluated [1/h]."""
NOISES = 10
"""Runs of one motion, each with its own noise."""
COURSES = {"four_mass_linear": 40, "four_mass": 30, "elbow": 40, "e12": 40, "six_axis": 8}
"""Motions per robot."""
EFFECTS = {
    "four_mass_linear": (
        ("coulomb_friction@motor_1:level=", (5e-4, 2e-3, 2e-2)),
        ("backlash@motor_1:gap=", (2e-5, 2e-4, 2e-3)),
        ("stiffness_error@body_1.rz:relative=", (1e-3, 1e-2, 1e-1)),
        ("payload_error@tool:relative=", (1e-3, 1e-2, 1e-1)),
    ),
    "elbow": (
        ("coulomb_friction@motor_1:level=", (0.05, 0.5, 5.0)),
        ("coulomb_friction@motor_2:level=", (0.05, 0.5, 5.0)),
        ("backlash@motor_1:gap=", (2e-6, 2e-5, 2e-4)),
        ("payload_error@tool:relative=", (1e-4, 1e-3, 1e-2)),
    ),
    "e12": (
        ("coulomb_friction@motor_1:level=", (0.1, 1.0, 10.0)),
        ("viscous_friction@motor_2:coefficient=", (0.3, 3.0, 30.0)),
        ("backlash@motor_2:gap=", (2e-6, 2e-5, 2e-4)),
        ("payload_error@tool:relative=", (1e-4, 1e-3, 1e-2)),
    ),
}
"""Effects and their sizes, by robot."""
ACCEPTED = {
    "elbow": ("payload_error@tool:relative=0.02", "viscous_friction@motor_1:coefficient=5"),
    "e12": ("payload_error@tool:relative=0.02", "viscous_friction@motor_2:coefficient=5"),
}
"""Accepted deviations of the robots from their models."""
GROWN = {
    "elbow": ("coulomb_friction@motor_2:level=", (3.0, 30.0, 100.0)),
    "e12": ("coulomb_friction@motor_1:level=", (10.0, 100.0, 300.0)),
}
"""Additional deviations, with their sizes."""
CALIBRATION, CHECKS, TRIED = 120, 6, 2
"""Length of the log that is accepted [s], further logs, and logs with an additional effect for each size."""
TRIALS, ONSET = 5, 20.0
"""Runs of each effect, and its onset [s]."""


def course(robot: str, seed: int, length: int = 40, effects: Sequence[str] = ()) -> Experiment:
    """Plan the diagnosis experiment of a robot, whose seed makes another sequence of motions."""
    changes: dict[str, Any] = {"robot": robot, "seed": seed, "diagnosis.length": length, "plant.effects": [*effects]}
    return Experiment.prepare(load_scenario("diagnosis").with_values(changes, "this page"))


def with_noise(planned: Experiment, seed: int) -> Experiment:
    """Return the same motion with noise of another seed."""
    noisy = replace(planned, scenario=planned.scenario.model_copy(update={"seed": seed}))
    vars(noisy)["reference"] = planned.reference  # computed once for all of them
    return noisy


def nominal() -> Iterator[tuple[str, Callable[[], dict[str, Any]]]]:
    """List runs of robots without a gap to their models."""
    for number in range(max(COURSES.values())):
        for robot, count in COURSES.items():
            if number < count:
                yield f"{robot} {number}", partial(nominal_case, robot, 5000 + number)


def nominal_case(robot: str, seed: int) -> dict[str, Any]:
    """Count false alarms of one motion with several noise seeds."""
    model, planned = load_model(robot), course(robot, seed)
    found: dict[str, Any] = {
        "robot": robot,
        "seed": seed,
        "hours": 0.0,
        "watched_hours": 0.0,
        "alarms": 0,
        "warnings": 0,
    }
    found |= {"runs": NOISES, "exceeded": [0] * len(RATES), "mean": [], "used_s": 0.0}
    for noise in range(NOISES):
        log = closed_loop(with_noise(planned, 100 * seed + noise))
        begun = time.thread_time()
        monitor = GapMonitor(model)
        watched = watch_log(log, monitor, name="nominal")
        found["used_s"] += time.thread_time() - begun
        found["hours"] += float(log.joint_states.stamp[-1] - log.joint_states.stamp[0]) / 3.6e12
        found["watched_hours"] += monitor.windows * 0.1 / 3600
        found["alarms"] += monitor.alarms
        found["warnings"] += monitor.warnings
        counted = exceeded(monitor, watched.values)
        found["exceeded"] = [a + b for a, b in zip(found["exceeded"], counted)]
        found["mean"].append(watched.values.mean(axis=0).tolist())
    found["mean"] = np.mean(found["mean"], axis=0).tolist()
    return found


def exceeded(monitor: GapMonitor, values: FloatArray) -> list[int]:
    """Count mean squares above the thresholds of several rates."""
    book, stream = monitor.book, monitor.stream
    counts = []
    for rate in RATES:
        limit = thresholds(book, stream.samples, false_alarms=rate).alarm
        count = 0
        for row, length in enumerate(LENGTHS):
            whole = values[: len(values) // length * length].reshape(-1, length, values.shape[1]).mean(axis=1)
            count += int(np.count_nonzero(whole > limit[row]))
        counts.append(count)
    return counts


def detection() -> Iterator[tuple[str, Callable[[], dict[str, Any]]]]:
    """List runs in which an effect begins."""
    for trial in range(TRIALS):
        for robot, effects in EFFECTS.items():
            for text, sizes in effects:
                for size in sizes:
                    name = f"{robot} {text}{size:g} {trial}"
                    yield name, partial(onset_case, robot, text, size, 6000 + trial)


def onset_case(robot: str, text: str, size: float, seed: int) -> dict[str, Any]:
    """Run a motion in which an effect begins; return the delay of the alarm and the reported location."""
    if (robot, seed) not in _PLANNED:
        _PLANNED[robot, seed] = course(robot, seed)
    planned = _PLANNED[robot, seed]
    log = spliced(planned, f"{text}{size:g}")
    watched = watch_log(log, GapMonitor(load_model(robot)), name="onset")
    onset = 1.0 + ONSET
    detected = [episode for episode in watched.episodes if episode.stamp * 1e-9 > onset - 0.1]
    found = {"robot": robot, "effect": text.rstrip("=").split(":")[0], "size": size, "seed": seed}
    found |= {"before": len(watched.episodes) - len(detected), "delay": None, "joint": "", "kind": ""}
    if detected:
        first = detected[0]
        found |= {"delay": first.stamp * 1e-9 + 0.1 - onset, "joint": first.joint, "kind": first.kind}
    return found


_PLANNED: dict[tuple[str, int], Experiment] = {}


def spliced(planned: Experiment, effect: str) -> Log:
    """Run a motion in which an effect begins; the state of the robot is continuous."""
    from flexros.compile.loop.arrays import LoopInputs, LoopState
    from flexros.compile.loop.kernel import compile_loop
    from flexros.scenario.closed_loop import run_log
    from flexros.simulate.plant import delayed_start
    from flexros.simulate.plant_model import PlantModel

    law, T = planned.scenario.controller, planned.sample_time
    changed = planned.models.plant.with_effects([parse_effect(effect, "this page")])
    plants = (planned.plant_model, PlantModel(changed.robot, changed.laws))
    ends = (round(ONSET / T), planned.n_samples)
    signals, parts, first = planned.signals(planned.scenario.seed), [], 0
    state = None
    for plant, end in zip(plants, ends):
        kernel = compile_loop(
            plant.functions(law.function(planned.loop_context)),
            sample_time=T,
            substeps=planned.scenario.substeps,
            delay=plant.delay,
        )
        if state is None:
            rest = plant.start(planned.start_state, planned.start_torque)
            state = delayed_start(
                rest, law.initial_state(planned.loop_context), planned.start_torque, kernel.line_length
            )
        else:
            robot = 2 * planned.plant.n_coordinates
            begun = plant.start(np.asarray(state.plant)[:robot].ravel(), parts[-1].command[-1])
            state = LoopState(begun, state.controller, state.line)
        inputs = LoopInputs(
            reference=planned.reference_signal[first:end],
            noise=signals.encoder_noise.rows(first, end - first),
            disturbance=signals.disturbance.rows(first, end - first),
            gains=planned.gains,
        )
        parts.append(kernel.run(state, end - first, inputs))
        state, first = parts[-1].final, end
    encoder, command, pose = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("encoder", "command", "tool_pose")
    )
    return run_log(planned, encoder, command, pose)


def accepted() -> Iterator[tuple[str, Callable[[], dict[str, Any]]]]:
    """List robots with an accepted gap."""
    for robot in ACCEPTED:
        yield robot, partial(accepted_case, robot)


def accepted_case(robot: str) -> dict[str, Any]:
    """Calibrate by one log and monitor further ones, with the accepted gap and with an additional effect."""
    model, known = load_model(robot), ACCEPTED[robot]

    def watched(seed: int, effects: Sequence[str], length: int, limits: Calibration | None) -> WatchedLog:
        return watch_log(
            closed_loop(course(robot, seed, length, effects)), GapMonitor(model, calibration=limits), name="log"
        )

    first = watched(8000, known, CALIBRATION, None)
    limits = calibrate(first.values, first.motion, model.robot.joint_names, model="", robot=robot, log="accepted")
    text, sizes = GROWN[robot]
    found: dict[str, Any] = {"robot": robot, "known": [*known], "accepted": limits.accepted, "effect": text.rstrip("=")}
    found["false"] = sum(len(watched(8001 + k, known, 40, limits).episodes) for k in range(CHECKS))
    found["told"] = {}
    for size in sizes:
        runs = [watched(8101 + k, (*known, f"{text}{size:g}"), 40, limits) for k in range(TRIED)]
        right = sum(run.episodes[-1].joint in text for run in runs if run.episodes and run.episodes[-1].joint)
        found["told"][f"{size:g}"] = [sum(bool(run.episodes) for run in runs), right, len(runs)]
    return found


def add(path: Path, cases: Iterator[tuple[str, Callable[[], dict[str, Any]]]]) -> None:
    """Run the cases that a file does not contain."""
    done = {json.loads(line)["case"] for line in path.read_text().splitlines()} if path.exists() else set()
    for name, case in cases:
        if name not in done:
            row = {"case": name, **case()}
            with path.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(row) + "\n")


def main() -> None:
    """Do one part of the work."""
    assert __doc__ is not None
    cases = {"nominal": nominal, "detection": detection, "accepted": accepted}
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("part", choices=[*cases, "page"], help="part of the work")
    parser.add_argument("work", nargs="?", type=Path, default=Path("bags/gap_monitor"), help="folder of its results")
    given = parser.parse_args()
    work, part = given.work, given.part
    work.mkdir(parents=True, exist_ok=True)
    if part in cases:
        add(work / f"{part}.jsonl", cases[part]())
    else:
        text = page_text(work, RATES, ONSET)
        (Path(__file__).parents[1] / "gap_monitor.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
