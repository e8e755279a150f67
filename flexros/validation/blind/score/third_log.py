"""The gap that the patch of a diagnosis closes on a third log, which neither fit nor holdout used."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import Field

from flexros.config.settings import Settings
from flexros.effects import RobotWithEffects
from flexros.effects.patching.patched_robot import load_model
from flexros.errors import FlexrosError
from flexros.validation.blind.diagnose_case import PATCH_FILE, case_settings
from flexros.validation.blind.seal import ROBOT_FILE

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.validation.blind.seal import OpenCase


class ThirdLog(Settings):
    """The gap numbers of a patch on the third log of a case."""

    before: float | None = Field(default=None, description="gap with the nominal model [1]")
    after: float | None = Field(default=None, description="gap with the patch [1]")
    closed_fraction: float | None = Field(
        default=None, description="share that the patch closes [1]; none where no gap shows"
    )
    failure: str = Field(default="", description="why the gap could not be measured; empty where it was")


def third_log(folder: Path, case: OpenCase) -> ThirdLog | None:
    """Measure the gap of the third log before and after the repair.

    Args:
        folder: Folder of the case, with its logs and the patch of its diagnosis.
        case: What is open of it.

    Returns:
        The numbers; None where the diagnosis gave no patch.
    """
    from flexros.gap.measure_gap import measure_gap
    from flexros.logs.reader import read_log
    from flexros.record.read import read_record
    from flexros.robot import load_robot

    if not (folder / PATCH_FILE).exists():
        return None
    robot, log = load_robot(folder / ROBOT_FILE), case.logs[2]
    try:
        repaired = load_model(folder / PATCH_FILE)
        record = read_record(read_log(folder / log), robot, name=f"{case.name}/{log}")
        numbers = measure_gap(record, RobotWithEffects(robot, ()), repaired=repaired, settings=case_settings()).numbers
    except FlexrosError as error:
        return ThirdLog(failure=str(error))
    return ThirdLog(before=numbers.before, after=numbers.after, closed_fraction=numbers.closed_fraction)
