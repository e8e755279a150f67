"""JSON of the comparison of diagnoses."""

from __future__ import annotations

from pydantic import Field

from flexros.cli.json_output.base import Output
from flexros.gap.schema import GapNumbers, Verdict


class ComparedDiagnosis(Output):
    """A diagnosis among others."""

    name: str = Field(description="its folder")
    log: str = Field(description="log that it was fitted to")
    robot: str = Field(description="nominal model")
    verdict: Verdict = Field(description="its verdict")
    gap: GapNumbers = Field(description="gap before and after the repair")


class ComparedParameter(Output):
    """A parameter of an effect, or a number of the model, over the diagnoses, in their order."""

    effect: str = Field(description="name of the effect; empty for a number of the model")
    location: str = Field(description="its location")
    name: str = Field(description="name of the parameter")
    unit: str = Field(description="SI unit, 1 for none")
    values: list[float | None] = Field(description="fitted values, in `unit`; null where it was not found")
    stds: list[float | None] = Field(description="their standard deviations, in `unit`")
    shares: list[float | None] = Field(description="share of the gap that opens without the effect [1]")
    p_same: float | None = Field(
        description="probability of values as far apart by chance, were the true ones the same [1]; null for one value"
    )


class ComparedDiagnoses(Output):
    """Several diagnoses side by side."""

    diagnoses: list[ComparedDiagnosis] = Field(description="the diagnoses in the order given")
    effects: list[ComparedParameter] = Field(description="parameters of effects, those of most diagnoses first")
    numbers: list[ComparedParameter] = Field(description="numbers of the nominal model that a diagnosis corrects")
