"""One law on one robot with one tuning, through all conditions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.config.settings import validate
from flexros.effects import parse_effect, place_effects
from flexros.errors import InputError
from flexros.scenario.batch import batch
from flexros.scenario.experiment import Experiment
from flexros.scenario.models import ScenarioModels
from flexros.scenario.scenario import Scenario
from flexros.validation.campaigns.linearisation.conditions import coulomb_values, draw_values, plant_effects
from flexros.validation.campaigns.linearisation.laws import LAWS, axes_of
from flexros.validation.campaigns.linearisation.robots import CALM, CHIRP, END, SECOND, Encoders, robot_with
from flexros.validation.campaigns.linearisation.tuning import LinearLoops, Tuning, equally_robust

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.scenario.batch import RunRecord
    from flexros.validation.campaigns.linearisation.conditions import Condition
    from flexros.validation.campaigns.linearisation.laws import Law
    from flexros.validation.campaigns.linearisation.robots import StudyRobot
    from flexros.validation.campaigns.linearisation.settings import LinearisationSettings

LOST = 50.0
"""Tool error beyond which a run counts as lost [mm] (chosen)."""
SETTLED = 0.1
"""Time over which a value at rest is averaged [s] (chosen)."""


@dataclass(frozen=True)
class Setup:
    """A law on a robot with its numbers.

    Attributes:
        robot: The robot.
        law: The law.
        tuning: Its numbers.
    """

    robot: StudyRobot
    law: Law
    tuning: Tuning


def law_part(settings: LinearisationSettings, robot: StudyRobot, law_name: str, how: str) -> dict[str, Any]:
    """Tune a law and run it under all conditions.

    Args:
        settings: Conditions and repetitions.
        robot: The robot.
        law_name: Name of the law.
        how: Name of the tuning.

    Returns:
        For JSON: `tuning`, and `runs` by condition, lists of one entry per run: `track` and `rms` (largest and root
        mean square tool error of the motion [mm]), `push`, `hold`, `motor`, `shake` (largest deviation after the step
        of the force, the part of it that remains, after the step of the motor torque, during the chirp [mm]), `noise`
        (rms of the change of the torque from sample to sample at rest, largest motor [Nm]); None in a run that was
        lost. A law that the robot does not fit has `refused` instead.
    """
    law = next(each for each in LAWS if each.name == law_name)
    nominal = robot_with(robot.name, Encoders(law.links))
    loops = LinearLoops(law, nominal, axes_of(nominal), robot.poses, 5e-4)
    try:
        tuning = (
            equally_robust(loops, robot.torque_noise)
            if how == "equal robustness"
            else loops.tuning(robot.bandwidth, law.first)
        )
        setup = Setup(robot, law, tuning)
        runs = {condition.name: _runs(settings, setup, condition) for condition in settings.conditions}
    except InputError as error:
        return {"refused": str(error)}
    return {"tuning": tuning.as_dict(), "runs": runs}


def _runs(settings: LinearisationSettings, setup: Setup, condition: Condition) -> dict[str, list[float | None]]:
    """Run the motion and the disturbances with all plants of a condition."""
    count = settings.draws if condition.random else settings.repetitions
    found: dict[str, list[float | None]] = {}
    for regulate in (False, True):
        experiment = _experiment(setup, condition, regulate=regulate)
        plant = experiment.plant
        values = draw_values(experiment.nominal, condition, count, settings.seed)
        if condition.coulomb:
            values |= coulomb_values(_largest_torque(setup), condition, count)
        wanted = experiment.reference.tool_pose[:, :3]
        step = experiment.sample_time

        def figure(
            record: RunRecord, regulate: bool = regulate, wanted: FloatArray = wanted, step: float = step
        ) -> Any:
            if record.diverged >= 0:
                return None
            error = 1e3 * (record.tool_pose[:, :3] - wanted)
            return _regulation(error, step) if regulate else _tracking(error, record.command, step)

        seeds = list(range(settings.seed, settings.seed + count))
        results = batch(experiment, figure, values=values, seeds=seeds, threads=1)
        assert plant is experiment.plant
        keys = ("push", "hold", "motor", "shake") if regulate else ("track", "rms", "noise")
        for key in keys:
            found[key] = [None if each is None else float(f"{each[key]:.4g}") for each in results]
    return found


def _experiment(setup: Setup, condition: Condition, *, regulate: bool) -> Experiment:
    """Prepare a task: the law knows the nominal robot, the plant has what the condition adds."""
    robot, law = setup.robot, setup.law
    nominal = robot_with(robot.name, Encoders(law.links))
    method: dict[str, Any] = {"method": law.feedforward} | ({"output": robot.output} if robot.output else {})
    task = {"disturbances": robot.disturbances(), "duration": END} if regulate else {"trajectory": robot.trajectory}
    controller = law.settings(axes_of(nominal), setup.tuning.bandwidth, setup.tuning.second)
    settings = {
        "name": "study", "robot": robot.name, "sample_time": condition.sample_time, "feedforward": method,
        "controller": {"kind": "pid", "kp": 0.0}, "start": list(robot.poses[0]), **task,
    }  # fmt: skip
    prepared = Experiment.prepare(validate(Scenario, settings, "the study"))
    scenario = validate(Scenario, settings | {"controller": controller}, "the study")
    plant = robot_with(robot.name, Encoders(law.links, condition.noise * nominal.spec.sensors.encoder_noise.value))
    hidden = place_effects(plant, [parse_effect(text, "the study") for text in plant_effects(plant, condition)])
    known = place_effects(nominal, [])
    experiment = replace(prepared, scenario=scenario, models=ScenarioModels(known, known, hidden))
    scenario.controller.check(experiment.loop_context)
    return experiment


def _largest_torque(setup: Setup) -> FloatArray:
    """Return the largest torque of every motor that the exact model needs for the motion [Nm], shape (M,)."""
    exact = replace(setup, law=next(law for law in LAWS if law.feedforward == "dae" and not law.links))
    from flexros.validation.campaigns.linearisation.conditions import EXACT

    return np.asarray(np.max(np.abs(_experiment(exact, EXACT, regulate=False).reference.torque), axis=0))


def _tracking(error: FloatArray, command: FloatArray, step: float) -> dict[str, float] | None:
    """Return the figures of the motion; None if the tool was lost."""
    size = np.linalg.norm(error, axis=1)
    if not np.max(size) < LOST:
        return None
    rest = command[: max(round(0.15 / step), 4)]
    noise = np.sqrt(np.mean(np.diff(rest, axis=0) ** 2, axis=0))
    return {"track": float(np.max(size)), "rms": float(np.sqrt(np.mean(size**2))), "noise": float(np.max(noise))}


def _regulation(error: FloatArray, step: float) -> dict[str, float] | None:
    """Return the figures of the disturbances; each window counts from where the tool was before it."""
    if not np.max(np.linalg.norm(error, axis=1)) < LOST:
        return None
    start, second, chirp, end = (round(time / step) for time in (CALM, SECOND, CHIRP, END))
    calm = round(SETTLED / step)

    def at(index: int) -> FloatArray:
        return np.asarray(np.mean(error[index - calm : index], axis=0))

    def largest(first: int, last: int, rest: FloatArray) -> float:
        return float(np.max(np.linalg.norm(error[first:last] - rest, axis=1)))

    return {
        "push": largest(start, second, at(start)),
        "hold": float(np.linalg.norm(at(second) - at(start))),
        "motor": largest(second, chirp, at(second)),
        "shake": largest(chirp, end, at(chirp)),
    }
