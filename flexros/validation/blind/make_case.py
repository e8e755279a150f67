"""Making a case: drawing what is hidden, writing its logs, sealing the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexros.atomic_file import write_whole
from flexros.errors import RunError
from flexros.identify.robot_file import identified_file
from flexros.logs.write_log import write_log
from flexros.random_streams import Stream, generator
from flexros.validation.blind.draw.arm_deviations import OUTSIDE_DRAWERS, STRUCTURE_DRAWERS
from flexros.validation.blind.draw.case_setting import Setting
from flexros.validation.blind.draw.conditions import believed_values, draw_conditions, tolerances
from flexros.validation.blind.draw.crowd_sizing import size_crowd
from flexros.validation.blind.draw.draw import Draft, draft, even, log_uniform
from flexros.validation.blind.draw.locations import places_of
from flexros.validation.blind.draw.motor_deviations import MOTOR_DRAWERS
from flexros.validation.blind.draw.nominal_filter import NominalFilter
from flexros.validation.blind.draw.scales import scales_of
from flexros.validation.blind.draw.sizing import Rehearsal, Sized, find_size
from flexros.validation.blind.plan import SIZES
from flexros.validation.blind.plant.plant import UnstableCaseError
from flexros.validation.blind.recorded_log import RecordedLog, record_log
from flexros.validation.blind.seal import CASE_FILE, ROBOT_FILE, OpenCase, Truth, sha256, write_truth

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from flexros.arrays import FloatArray
    from flexros.validation.blind.draw.conditions import Conditions
    from flexros.validation.blind.draw.scales import Scales
    from flexros.validation.blind.plan import Case

DRAWERS = {**MOTOR_DRAWERS, **STRUCTURE_DRAWERS, **OUTSIDE_DRAWERS}
"""Drawing functions of all deviations, by name."""
LOGS = ("fit", "holdout", "third")
"""Folders of the logs of a case: to fit, to check on, and one that the diagnosis is not given."""
ROUNDING = 2 + len(LOGS)
"""Number of the random stream of the step of encoders, behind those of the case, its reference and its logs."""
ATTEMPTS = 20
"""Largest number of draws of a case (chosen)."""


class UndrawnCaseError(RunError):
    """None of several draws of a case has a stable loop."""


@dataclass(frozen=True)
class MakeSettings:
    """Settings of the logs of a case.

    Attributes:
        seed: Seed of the check.
        stream: Stream of development or of evaluation.
        durations: Lengths of the three logs, about [s].
        secret: Random text that the seals are salted with.
        encoder_steps: Smallest and largest step to which all encoders of a case round their positions, over their noise
            [1]; drawn evenly in the logarithm from a stream of its own. None: they do not round.
    """

    seed: int
    stream: Stream = Stream.BLIND_EVALUATION
    durations: tuple[float, float, float] = (40.0, 20.0, 20.0)
    secret: str = ""
    encoder_steps: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Drawn:
    """A case that was drawn.

    Attributes:
        setting: How it is run.
        conditions: Noise and clocks.
        reference: Reference of the log to fit, with feedforward, shape (n, 3 M).
        hidden: What is hidden, with the expected gain of each.
        robot_file: Text of the nominal model.
    """

    setting: Setting
    conditions: Conditions
    reference: FloatArray
    hidden: tuple[Sized, ...]
    robot_file: str


def make_case(case: Case, settings: MakeSettings, logs: Path, truths: Path) -> None:
    """Make the logs of a case and seal its truth; a case that exists is kept.

    Args:
        case: The case.
        settings: How.
        logs: Folder of all logs; receives a folder for the case.
        truths: Folder of all truths; receives a file for the case.

    Raises:
        RunError: No draw gave a stable loop.
    """
    folder = logs / case.name
    if (folder / CASE_FILE).exists():
        return
    folder.mkdir(parents=True, exist_ok=True)
    drawn, takes = _drawn_with_logs(case, settings)
    for name, take in zip(LOGS, takes, strict=True):
        write_log(take.log(), _fresh(folder / name))
    write_whole(folder / ROBOT_FILE, drawn.robot_file)
    truths.mkdir(parents=True, exist_ok=True)
    seal = write_truth(_truth(case, drawn, settings), truths)
    opened = OpenCase(name=case.name, robot=case.robot, logs=LOGS, seal=seal)
    write_whole(folder / CASE_FILE, opened.model_dump_json(indent=1) + "\n")


def _drawn_with_logs(case: Case, settings: MakeSettings) -> tuple[Drawn, list[RecordedLog]]:
    """Draw until all three logs have a stable loop."""
    for attempt in range(ATTEMPTS):
        try:
            drawn = draw_case(case, settings, attempt)
            return drawn, [
                record_log(
                    drawn, case.tool, place, settings.durations[place], _random(case, settings, attempt, 2 + place)
                )
                for place in range(len(LOGS))
            ]
        except UnstableCaseError:
            continue
    raise UndrawnCaseError(
        f"{case.name} ({', '.join(case.effects) or 'nothing'} on {case.robot}) was drawn {ATTEMPTS} times and its loop "
        "was never stable; another seed draws other cases"
    )


def draw_case(case: Case, settings: MakeSettings, attempt: int = 0) -> Drawn:
    """Draw setting, conditions, nominal model and what is hidden.

    Args:
        case: The case.
        settings: Seed and lengths.
        attempt: Number of the attempt.

    Returns:
        All but the logs.
    """
    random = _random(case, settings, attempt, 0)
    setting = Setting.draw(case.robot, random)
    robot = setting.robot
    believed = believed_values(robot, case.nuisance, random)
    conditions = draw_conditions(case.nuisance, random)
    if settings.encoder_steps is not None:
        step = log_uniform(_random(case, settings, attempt, ROUNDING), *settings.encoder_steps)
        conditions = replace(conditions, encoder_step=step)
    reference = setting.reference(settings.durations[0], _random(case, settings, attempt, 1))
    known = NominalFilter(robot, setting.sample_time, tolerances(robot, case.nuisance))
    rehearsal = Rehearsal(setting, reference, known, conditions.visibility)
    hidden = _hidden(case, rehearsal, random)
    return Drawn(setting, conditions, reference, hidden, identified_file(robot, believed, "as known to the user"))


def _hidden(case: Case, rehearsal: Rehearsal, random: np.random.Generator) -> tuple[Sized, ...]:
    if not case.effects:
        return ()
    setting = rehearsal.setting
    scales = scales_of(setting.robot, rehearsal.run(()), setting.sample_time)
    if case.kind == "crowd":
        return _crowd(case, rehearsal, scales, random)
    hidden = []
    for effect in case.effects:
        place = str(random.choice(places_of(effect, setting.robot)))
        drafted: Draft = draft(DRAWERS, effect, scales, place, random)
        hidden.append(find_size(drafted, rehearsal, log_uniform(random, *SIZES[case.size])))
    return tuple(hidden)


def _crowd(case: Case, rehearsal: Rehearsal, scales: Scales, random: np.random.Generator) -> tuple[Sized, ...]:
    """Draw shapes and sizes of the effects of a crowd; dry friction is even, or a bias would be part of it."""
    drafts = []
    for effect, place in zip(case.effects, case.places, strict=True):
        drafted = draft(DRAWERS, effect, scales, place, random)
        drafts.append(even(drafted) if effect == "coulomb_friction" else drafted)
    targets = [log_uniform(random, *SIZES[case.size]) for _ in drafts]
    return size_crowd(drafts, targets, rehearsal)


def _truth(case: Case, drawn: Drawn, settings: MakeSettings) -> Truth:
    return Truth(
        name=case.name,
        kind=case.kind,
        robot=case.robot,
        size=case.size,
        nuisance=case.nuisance,
        tool=case.tool,
        deviations=tuple(one.deviation for one in drawn.hidden),
        gains=tuple(one.gain for one in drawn.hidden),
        sample_time=drawn.setting.sample_time,
        motion=drawn.setting.motion,
        conditions=drawn.conditions.figures(),
        robot_sha256=sha256(drawn.robot_file),
        salt=sha256(f"{settings.secret}/{settings.seed}/{case.name}"),
    )


def _random(case: Case, settings: MakeSettings, attempt: int, part: int) -> np.random.Generator:
    return generator(settings.seed, settings.stream, case.number, attempt, part)


def _fresh(folder: Path) -> Path:
    """Remove what an aborted run left of a log."""
    import shutil

    if folder.exists():
        shutil.rmtree(folder)
    return folder
