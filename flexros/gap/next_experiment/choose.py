"""Choose the next experiment: the one that separates the remaining explanations best, by simulation."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.effects import RobotWithEffects
from flexros.errors import InputError, RunError
from flexros.gap.next_experiment.catalogue import CATALOGUE
from flexros.gap.next_experiment.separation import Explained, separation, trial
from flexros.gap.schema import EffectLocation, NextExperiment
from flexros.gap.settings import DiagnosisSettings, NextExperimentSettings

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from typing import Any

    from flexros.effects import PlacedEffect
    from flexros.gap.next_experiment.catalogue import CatalogueEntry
    from flexros.robot import Robot


SLOWEST = 2e-3
"""Longest time between two samples of an experiment [s] (chosen): its controller, which has the same rate, needs a few
samples in the period of a vibration. At 0.5 ms experiments of seven axes took most of a diagnosis."""


@dataclass(frozen=True)
class Separated:
    """Expected result of an experiment of the catalogue.

    Attributes:
        entry: The experiment.
        gain: Expected logarithm of the odds of the two closest explanations, equally likely a priori [nats].
        closest: Indices of these two in the list of explanations.
    """

    entry: CatalogueEntry
    gain: float
    closest: tuple[int, int]


def next_experiment(
    robot: Robot | RobotWithEffects,
    survivors: Sequence[Sequence[PlacedEffect]],
    *,
    name: str = "",
    sample_time: float = 0.0,
    tool_measured: bool = False,
    tolerance: Mapping[str, float] | None = None,
    prescribed: tuple[int, ...] = (),
    done: Collection[str] = (),
    settings: DiagnosisSettings | None = None,
    entries: Sequence[CatalogueEntry] = CATALOGUE,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> NextExperiment | None:
    """Choose the experiment that separates the two closest explanations best, or a cheaper one that does so clearly.

    Args:
        robot: The nominal model.
        survivors: Remaining explanations with their fitted parameters, the most probable one first.
        name: Robot name or file for the command; default: where it was loaded from.
        sample_time: Time between two samples of the log that was diagnosed [s]. Where its recorder is slower than the
            robot file says, so are the experiments, up to `SLOWEST`.
        tool_measured: Whether the log has tool positions already.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; default: those of the robot file.
        prescribed: Motors of endless inertia in the model, as their motion was prescribed.
        done: Names of experiments that were run already.
        settings: Settings of the diagnosis.
        entries: Experiments to choose from.
        progress: Called with the completed share.
        stop: Asked between simulations; True ends the choice, among the experiments that were evaluated until then.

    Returns:
        The experiment; None where there are fewer than two explanations, or no experiment can be run.
    """
    model = robot if isinstance(robot, RobotWithEffects) else RobotWithEffects(robot, ())
    name = name or file_or_name(model.robot)
    period = min(sample_time, SLOWEST)
    slower = {"sample_time": period} if period > model.robot.sample_time else {}
    model = replace(model, robot=model.robot.with_values(slower))
    settings = settings or DiagnosisSettings()
    choice = settings.next_experiment or NextExperimentSettings()
    explained = [
        Explained(model, tuple(placed), settings, tolerance or {}, prescribed) for placed in survivors[: choice.most]
    ]
    if len(explained) < 2:
        return None
    candidates = [entry for entry in entries if entry.name not in done and not (entry.tool and tool_measured)]
    possible: list[Separated] = []
    for number, entry in enumerate(candidates, 1):
        if stop():
            break
        result = separated(explained, entry, choice.seed, choice.length, stop)
        possible += [] if result is None else [result]
        plenty = result is not None and result.gain >= choice.plenty
        if progress is not None:
            progress(1.0 if plenty else number / len(candidates))
        if plenty:
            break
    if not possible:
        return None
    most = max(result.gain for result in possible)
    best = next(result for result in possible if result.gain >= min(choice.enough * most, choice.plenty))
    keys = best.entry.keys(model.robot, choice.length)
    effects = {(one.effect.name, one.location): None for index in best.closest for one in explained[index].placed}
    return NextExperiment(
        name=best.entry.name,
        description=best.entry.description,
        separates=tuple(EffectLocation(effect=effect, location=location) for effect, location in effects),
        expected_gain=best.gain,
        command=command_of(keys | slower, name, choice.seed),
    )


def separated(
    survivors: Sequence[Explained],
    entry: CatalogueEntry,
    seed: int,
    length: float,
    stop: Callable[[], bool] = lambda: False,
) -> Separated | None:
    """Simulate an experiment with every explanation and compare all pairs.

    Args:
        survivors: Explanations of one nominal model with their fitted parameters, at least two.
        entry: The experiment.
        seed: Its seed.
        length: Its approximate length [s].
        stop: Asked between simulations; True ends the comparison without a result.

    Returns:
        The separation of the two closest; None where a run would be aborted or is not possible with this robot, or the
        comparison was ended.
    """
    trials, of_model = [], "model.values."
    try:
        keys = entry.keys(survivors[0].model.robot, length)
        known = {key.removeprefix(of_model): value for key, value in keys.items() if key.startswith(of_model)}
        keys = {key: value for key, value in keys.items() if not key.startswith(of_model)}
        explained = [one.with_values(known) for one in survivors]
        for truth in explained:
            if stop():
                return None
            trials.append(trial(truth, keys, seed, tool=entry.tool))
    except (RunError, InputError):  # such as weight beyond the torque limits at its pose
        return None
    gains = {}
    for i, j in combinations(range(len(explained)), 2):
        if stop():
            return None
        forward = separation(explained[i], explained[j], trials[i])
        backward = separation(explained[j], explained[i], trials[j])
        gains[i, j] = 0.5 * (forward + backward)
    closest = min(gains, key=lambda pair: gains[pair])
    return Separated(entry, gains[closest], closest)


def command_of(keys: Mapping[str, Any], name: str, seed: int) -> str:
    """Return the shell command that runs an experiment.

    Args:
        keys: Keys of scenario `diagnosis` that differ, by dotted name.
        name: Name or file of the robot.
        seed: Seed of the experiment.
    """
    words = ["flexros", "run", "diagnosis", "--model", name, "--seed", str(seed)]
    for key, value in keys.items():
        words += ["--set", f"{key}={json.dumps(value)}"]
    return shlex.join(words)


def file_or_name(robot: Robot) -> str:
    """Return the file that a robot was loaded from, otherwise its name.

    Args:
        robot: The robot.
    """
    return robot.source if Path(robot.source).is_file() else robot.name
