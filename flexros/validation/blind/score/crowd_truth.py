"""What the true effects of a crowd close and make up, as a measure of what a diagnosis says of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import Field

from flexros.config.settings import Settings
from flexros.effects import RobotWithEffects
from flexros.errors import FlexrosError
from flexros.validation.blind.diagnose_case import case_settings
from flexros.validation.blind.score.third_log import ThirdLog
from flexros.validation.blind.score.true_model import library_effects, true_model
from flexros.validation.blind.seal import ROBOT_FILE

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.residuals.fit_data import FitData
    from flexros.record.record import Record
    from flexros.robot import Robot
    from flexros.validation.blind.deviation import Deviation
    from flexros.validation.blind.seal import OpenCase, Truth


class TrueShare(Settings):
    """The share of the gap that a hidden effect makes up on held-out data."""

    effect: str = Field(description="its name")
    location: str = Field(description="its location")
    share_first: float | None = Field(description="share that closes when it alone is added [1]; none: no gap shows")
    share_last: float | None = Field(description="share that opens when it alone is removed [1]; none: no gap shows")


class CrowdTruth(Settings):
    """Figures of the true effects at their true numbers, on the true robot."""

    third: ThirdLog | None = Field(default=None, description="gap of the third log with them")
    budget: tuple[TrueShare, ...] = Field(default=(), description="gap of the second log divided among them")


def crowd_truth(folder: Path, case: OpenCase, truth: Truth) -> CrowdTruth | None:
    """Measure what the truth closes on the third log, and divide the gap of the second one as a diagnosis does.

    Args:
        folder: Folder of the case, with its logs.
        case: What is open of it.
        truth: What is hidden in it.

    Returns:
        The figures; None where no crowd is hidden.
    """
    from flexros.gap.checked_log import checked_log
    from flexros.logs.reader import read_log
    from flexros.robot import load_robot

    if truth.kind != "crowd":
        return None
    robot = load_robot(folder / ROBOT_FILE)
    try:
        second, third = (checked_log(read_log(folder / log), robot, name=log) for log in case.logs[1:])
        return CrowdTruth(third=_third(third, robot, truth), budget=_budget(second, robot, truth))
    except FlexrosError as error:
        return CrowdTruth(third=ThirdLog(failure=str(error)))


def _third(record: Record, robot: Robot, truth: Truth) -> ThirdLog:
    from flexros.gap.measure_gap import measure_gap

    found = measure_gap(record, RobotWithEffects(robot, ()), repaired=true_model(truth), settings=case_settings())
    numbers = found.numbers
    return ThirdLog(before=numbers.before, after=numbers.after, closed_fraction=numbers.closed_fraction)


def _budget(record: Record, robot: Robot, truth: Truth) -> tuple[TrueShare, ...]:
    """Add every effect first and remove it last; numbers of the nominal model are fitted within their tolerance."""
    from flexros.gap.held_out.closed_share import closed_fraction
    from flexros.gap.residuals.prepare_fit_data import fit_data

    nominal = RobotWithEffects(robot, ())
    data = fit_data(record, nominal, case_settings())
    hidden = library_effects(truth)
    before, after = _errors(nominal, data), _errors(true_model(truth, robot=robot), data)
    rows = []
    for number, one in enumerate(hidden):
        parts = [one], _without(hidden, number)
        first, last = (_errors(true_model(truth, part, robot), data) for part in parts)
        closed = closed_fraction(before, first, record.sample_time)
        rows.append(
            TrueShare(
                effect=one.effect,
                location=one.location,
                share_first=None if closed is None else closed.value,
                share_last=None if closed is None else (last.mean - after.mean) / (before.mean - 1.0),
            )
        )
    return tuple(rows)


def _without(items: Sequence[Deviation], number: int) -> list[Deviation]:
    return [*items[:number], *items[number + 1 :]]


def _errors(model: RobotWithEffects, data: FitData) -> AheadErrors:
    """Predict a log 0.1 s ahead; tolerated numbers of the model are fitted."""
    from flexros.gap.candidates.tolerance import tolerance_of
    from flexros.gap.fit.null_fit import fit_null
    from flexros.gap.held_out.errors_ahead import errors_ahead
    from flexros.gap.held_out.gap_floor import over_expected_floor

    null = fit_null(data, model, tolerance_of(model.robot, {}), case_settings().fit)
    return over_expected_floor(errors_ahead(null.fit, data), model, data)
