"""One truth of a hard pair: a short log, its diagnosis, the experiment that it proposes, and the diagnosis of that."""

from __future__ import annotations

import json
import shlex
from typing import TYPE_CHECKING, Any

from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.settings import DiagnosisSettings
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.schema import Diagnosis
    from flexros.record.record import Record
    from flexros.validation.campaigns.hard_pairs.settings import HardPairsSettings

VALUES = "model.values."


def pair_part(settings: HardPairsSettings, truth: str) -> dict[str, Any]:
    """Diagnose a short log of a hidden effect, then the experiment that the diagnosis proposes.

    Args:
        settings: Robot and short log.
        truth: The hidden effect, as EFFECT@LOCATION:PARAMETER=VALUE.

    Returns:
        For JSON: `first`, the answer to the short log, and `second`, that to the proposed experiment; None where
        nothing was proposed.
    """
    keys = {"robot": settings.robot, "seed": settings.seed, **settings.short}
    record = _record(keys, truth)
    short = record.part(0, min(round(settings.duration / record.sample_time), record.n_samples))
    first = diagnose(short, load_model(settings.robot), settings=DiagnosisSettings(threads=1, where=None)).diagnosis
    command = first.next_experiment.command if first.next_experiment is not None else ""
    return {"truth": truth, "first": _answer(first), "second": _second(command, truth) if command else None}


def keys_of(command: str) -> dict[str, Any]:
    """Read the command of a proposed experiment: keys of its scenario by dotted name.

    Args:
        command: A line `flexros run diagnosis --model ROBOT --seed N --set KEY=VALUE ...`.

    Raises:
        InputError: It is another command.
    """
    words = shlex.split(command)
    if words[:3] != ["flexros", "run", "diagnosis"] or len(words) % 2 == 0:
        raise InputError(f"'{command}' does not run the diagnosis experiment; give the command of a next experiment")
    keys: dict[str, Any] = {}
    for option, text in zip(words[3::2], words[4::2]):
        if option == "--set":
            name, _, value = text.partition("=")
            keys[name] = json.loads(value)
        else:
            keys[{"--model": "robot", "--seed": "seed"}[option]] = text if option == "--model" else int(text)
    return keys


def _second(command: str, truth: str) -> dict[str, Any]:
    keys = keys_of(command)
    known = {name.removeprefix(VALUES): value for name, value in keys.items() if name.startswith(VALUES)}
    robot = load_robot(keys["robot"])
    believed = robot.with_values(known, "the known load") if known else robot
    diagnosis = diagnose(_record(keys, truth), believed, settings=DiagnosisSettings(threads=1, where=None)).diagnosis
    return _answer(diagnosis)


def _record(keys: Mapping[str, Any], truth: str) -> Record:
    scenario = load_scenario("diagnosis").with_values({**keys, "plant.effects": [truth]})
    experiment = Experiment.prepare(scenario)
    nominal: RobotWithEffects = load_model(scenario.robot)
    return checked_log(closed_loop(experiment), nominal.robot, name=truth)


def _answer(found: Diagnosis) -> dict[str, Any]:
    following = found.next_experiment
    return {
        "verdict": found.verdict,
        "causes": [[one.effect, one.location, one.probability] for one in found.causes],
        "groups": [[place.effect for place in group] for group in found.ambiguity_groups],
        "experiment": None if following is None else following.name,
        "expected_gain": None if following is None else following.expected_gain,
        "command": None if following is None else following.command,
    }
