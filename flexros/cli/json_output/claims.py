"""JSON of the commands that show what FlexROS claims: demonstration, benchmarks, campaigns, blind check."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from flexros.cli.json_output.base import OpenOutput, Output
from flexros.cli.json_output.runs import RunOutcome
from flexros.gap.schema import ORDER, BudgetShare, Cause, GapNumbers, ModelNumber, Unexplained, Verdict, Waterfall


class PathErrorCompared(Output):
    """Largest path errors of a method in a case of the thesis."""

    method: str = Field(description="feedforward")
    case: str = Field(description="robot and motion")
    published: float | None = Field(description="number in the thesis [m]; null where there is none")
    independent_reading: float | None = Field(description="from an independent program [m]; null where there is none")
    this_run: float | None = Field(description="of this run [m]; null where it was left out")


class DemonstratedRun(RunOutcome):
    """One run of the demonstration; further keys are figures of the transport, with the unit in the name."""

    label: str = Field(description="name of the run")
    equal_to_direct: bool | None = Field(description="whether its log is that of an in-process run in every bit")


class Repaired(Output):
    """A hidden effect: what was found, and the run with the repaired feedforward."""

    verdict: Verdict = Field(description="verdict of the diagnosis")
    causes: list[Cause] = Field(description=ORDER)
    patch: str | None = Field(description="file of the repaired model; null where there is nothing to repair")
    path_error_without_effect_m: float = Field(description="largest path error without the effect [m]")
    path_error_before_m: float = Field(description="with it [m]")
    path_error_after_m: float | None = Field(description="with it and the repaired feedforward [m]")


class MeasuredMachine(Output):
    """Budget of the gap of a measured machine."""

    data: str = Field(description="whose data, under which licence")
    verdict: Verdict = Field(description="verdict of the diagnosis")
    causes: list[Cause] = Field(description=ORDER)
    gap: GapNumbers = Field(description="gap before and after the repair")
    budget: list[BudgetShare] = Field(description="the gap divided among effects, the largest first")
    waterfall: list[Waterfall] = Field(description="the gap at each joint, an effect at a time")
    unexplained: list[Unexplained] = Field(description="what is left, by joint")
    model_numbers: list[ModelNumber] = Field(description="parameters of the model that are off")


class Demonstrated(Output):
    """The demonstration."""

    path_error_max_m: list[PathErrorCompared] = Field(description="path errors, with those of the thesis")
    caveats: list[str] = Field(description="what to know when comparing")
    runs: list[DemonstratedRun] = Field(description="in their order")
    folder: str = Field(description="folder of logs and reports")
    repair: Repaired | None = Field(default=None, description="missing with --no-repair")
    measured: MeasuredMachine | None = Field(default=None, description="missing with --no-measured")


class BenchmarkedSpeed(Output):
    """Speed on this machine."""

    machine: dict[str, Any] = Field(description="processor, system, and versions by package")
    results: dict[str, list[dict[str, Any]]] = Field(description="rows by benchmark, units in the keys")


class CampaignFigures(OpenOutput):
    """Figures of one campaign; the keys are its own, as in its JSON file in the folder `data`."""


class BlindScore(Output):
    """The blind check: shares have hits, cases and the 95 % interval low to high."""

    visible_from: float = Field(description="size from which an effect counts as well above the noise [1]")
    all: dict[str, Any] = Field(description="figures of all cases")
    robot: dict[str, dict[str, Any]] = Field(description="the same by robot")
    nuisance: dict[str, dict[str, Any]] = Field(description="by what is disturbed")
    size: dict[str, dict[str, Any]] = Field(description="by size of the effect")
    tool: dict[str, dict[str, Any]] = Field(description="by whether the tool was tracked")
    motion: dict[str, dict[str, Any]] = Field(description="by motion")
    sample_time: dict[str, dict[str, Any]] = Field(description="by sample time")
    effects: dict[str, dict[str, Any]] = Field(description="by single effect")
    crowds: dict[str, dict[str, Any]] = Field(description="cases with many effects, by nominal model")
    confusion: dict[str, dict[str, int]] = Field(description="first cause by true effect, number of cases [1]")
