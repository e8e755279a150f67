"""One setting on one development case: the case is made again, and diagnosed with every factor on the setting."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from flexros.errors import FlexrosError, InputError
from flexros.gap.diagnose import diagnose
from flexros.random_streams import Stream
from flexros.validation.blind.diagnose_case import case_settings, read_logs
from flexros.validation.blind.make_case import MakeSettings, make_case
from flexros.validation.blind.seal import read_case
from flexros.validation.campaigns.sensitivity.variation import numeric_keys, varied

if TYPE_CHECKING:
    from flexros.gap.schema import Diagnosis
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record
    from flexros.robot import Robot
    from flexros.validation.blind.plan import Case
    from flexros.validation.campaigns.sensitivity.settings import SensitivitySettings


def case_part(settings: SensitivitySettings, case: Case, key: str) -> dict[str, Any]:
    """Diagnose a case with one setting multiplied by each factor.

    Args:
        settings: Seed, lengths and factors.
        case: The case.
        key: Dotted name of the setting; empty for the defaults.

    Returns:
        For JSON: `answers`, one per factor (one alone for the defaults), each with `verdict`, `cause`, `location`,
        `probability` and `closed_fraction`, or with `refused`, the reason why there is no answer.
    """
    stream = Stream.BLIND_DEVELOPMENT
    make = MakeSettings(seed=settings.seed, stream=stream, durations=settings.durations)
    with TemporaryDirectory(prefix="flexros_sensitivity_") as folder:
        logs = Path(folder) / "logs"
        make_case(case, make, logs, Path(folder) / "truths")
        robot, record, holdout = read_logs(logs / case.name, read_case(logs / case.name))
    default = case_settings()
    if not key:
        return {"answers": [_answer(robot, record, holdout, default)]}
    answers = []
    for factor in settings.factors:
        try:
            changed = varied(default, key, factor)
        except InputError as error:
            answers.append({"refused": str(error)})
            continue
        same = numeric_keys(changed) == numeric_keys(default)
        answers.append(
            {"refused": "the rounded value is the default"} if same else _answer(robot, record, holdout, changed)
        )
    return {"answers": answers}


def _answer(robot: Robot, record: Record, holdout: Record, settings: DiagnosisSettings) -> dict[str, Any]:
    """Diagnose and return what the study compares; an error of the diagnosis is an answer as well."""
    try:
        diagnosis: Diagnosis = diagnose(record, robot, holdout=holdout, settings=settings).diagnosis
    except FlexrosError as error:
        return {"refused": str(error)}
    cause = diagnosis.causes[0] if diagnosis.causes else None
    return {
        "verdict": diagnosis.verdict,
        "cause": None if cause is None else cause.effect,
        "location": None if cause is None else cause.location,
        "probability": None if cause is None else cause.probability,
        "closed_fraction": diagnosis.gap.closed_fraction,
    }
