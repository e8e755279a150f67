"""The key `diagnosis` of a scenario: length, parts and sizes of the diagnosis experiment."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import Field, model_validator

from flexros.config.per_motor import PositivePerMotor
from flexros.config.settings import Settings

PartName: TypeAlias = Literal["creep", "presliding", "multisine", "biased", "moves", "steps"]
"""Parts of the experiment between the rests."""

WEIGHTS: dict[PartName, float] = {
    "creep": 10.0,
    "presliding": 5.0,
    "multisine": 13.5,
    "biased": 4.5,
    "moves": 4.5,
    "steps": 1.5,
}
"""Time of every part relative to the others [1] (chosen)."""


class DiagnosisSpecification(Settings):
    """A diagnosis experiment: rests, creep, small reversals, multisines, fast moves and steps.

    In a scenario, for example::

        diagnosis: {length: 40, intensity: 0.8, parts: [creep, multisine, moves]}

    Omitted sizes follow from the parameters of the robot, see `flexros.identify.diagnosis_experiment.scales`.
    """

    length: float = Field(default=40.0, ge=10.0, le=3600.0, description="length of the experiment, about [s]")
    parts: tuple[PartName, ...] = Field(
        default=tuple(WEIGHTS),
        min_length=1,
        max_length=100,
        description="parts, each as often as it is listed: creep in both directions, presliding (small slow "
        "reversals), multisine, biased (multisine on a slow swing), moves (fast), steps",
    )
    poses: int = Field(default=3, ge=1, le=12, description="poses of the parts in turn, including the initial one [1]")
    dwell: float = Field(default=0.3, ge=0.05, le=60.0, description="rest after a fast move [s]")
    intensity: float = Field(
        default=1.0, gt=0.0, le=1.2, description="size of multisines, moves and steps relative to the usual one [1]"
    )
    levels: tuple[float, ...] = Field(
        default=(0.02, 0.06, 0.18),
        min_length=1,
        description="rms torque of the multisines, each as a share of the torque scale [1]",
    )
    bias: float = Field(
        default=0.35, ge=0.0, le=0.8, description="peak torque of the slow swing of biased, share of the torque scale"
    )
    lowest: float | None = Field(
        default=None, gt=0.0, description="lowest line of the multisines [Hz]; default: three over the period"
    )
    highest: float | None = Field(
        default=None, gt=0.0, description="highest line of the multisines [Hz]; default: 0.06 of the sampling rate"
    )
    creep_speeds: tuple[float, ...] = Field(
        default=(1.0, 3.0, 0.05),
        min_length=1,
        description="speeds of the creep in both directions, relative to the creep stroke over 0.3 of the part's "
        "time [1]",
    )
    creep: PositivePerMotor | None = Field(
        default=None,
        description="stroke of the creep, one or one per motor [rad or m]; default: 2.5 turns of the rotor",
    )
    reversal: float = Field(
        default=1.0, gt=0.0, le=10.0, description="size of the small slow reversals relative to the usual one [1]"
    )
    reach: PositivePerMotor | None = Field(
        default=None, description="how far a joint may leave its start, one or one per motor [rad or m]"
    )
    speed: PositivePerMotor | None = Field(
        default=None, description="largest speed, one or one per motor [rad/s or m/s]"
    )
    acceleration: PositivePerMotor | None = Field(
        default=None, description="largest acceleration, one or one per motor [rad/s^2 or m/s^2]"
    )
    seed: int | None = Field(
        default=None,
        ge=0,
        lt=2**63,
        description="seed of poses, phases, lines and order of the parts; default: that of the scenario [1]",
    )

    @model_validator(mode="after")
    def _sizes_and_band_are_possible(self) -> DiagnosisSpecification:
        for key in ("levels", "creep_speeds"):
            if any(value <= 0.0 for value in getattr(self, key)):
                raise ValueError(f"{key} is {list(getattr(self, key))}, allowed are numbers above 0; correct them")
        if self.lowest is not None and self.highest is not None and self.highest <= self.lowest:
            raise ValueError(f"highest is {self.highest:g} Hz, allowed is above lowest = {self.lowest:g} Hz; raise it")
        return self
