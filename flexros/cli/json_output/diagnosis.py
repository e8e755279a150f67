"""JSON of the comparison of diagnoses and of the gap monitor; that of a diagnosis is `flexros.gap.schema`."""

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
    """A parameter of an effect, or one of the model, over the diagnoses, in their order."""

    effect: str = Field(description="name of the effect; empty for a parameter of the model")
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
    numbers: list[ComparedParameter] = Field(description="parameters of the nominal model that a diagnosis corrects")


class Alarm(Output):
    """An alarm."""

    since_s: float = Field(description="when the mismatch began [s]")
    told_s: float = Field(description="when the alarm was raised [s]")
    message: str = Field(description="what was seen, one sentence")
    joint: str = Field(description="joint where it shows most")
    kind: str = Field(description="kind of the alarm")


class MotorReading(Output):
    """The last second of a motor; torques in Nm, or N where it is linear."""

    gap: float | None = Field(default=None, description="prediction error over its noise, mean square [1]")
    sudden_over_noise: float | None = Field(default=None, description="innovation over its noise, mean square [1]")
    torque_over_noise: float | None = Field(default=None, description="missing torque over its noise, mean square [1]")
    missing_torque_rms: float | None = Field(default=None, description="rms of the missing torque")
    missing_torque_mean: float | None = Field(default=None, description="mean of the missing torque")
    missing_torque_floor: float | None = Field(default=None, description="what noise alone gives")
    share_of_alarm: float = Field(description="statistic over its threshold [1]")
    since_s: float | str = Field(description="begin of an alarm [s]; empty for none")


class Monitored(Output):
    """A log as the gap monitor saw it."""

    message: str = Field(description="state of the robot, one sentence")
    gap: float | None = Field(default=None, description="of the motor where it is largest [1]")
    share_of_alarm: float = Field(description="largest statistic over its threshold [1]")
    place: str = Field(description="where the mismatch shows")
    joint: str = Field(description="its joint")
    seen: float = Field(description="share of the last window that was seen [1]")
    alarms: list[Alarm] = Field(description="in order of time")
    motors: dict[str, MotorReading] = Field(description="by motor")
    windows: int = Field(description="windows of 0.1 s [1]")
    settling_windows: int = Field(description="windows in which the observer settled [1]")
    states: int = Field(description="measurements [1]")
    commands: int = Field(description="commands [1]")
    late: int = Field(description="commands that came late [1]")
    unusable: int = Field(description="messages that could not be used [1]")
    missing: int = Field(description="missing samples [1]")
    lost_windows: int = Field(description="windows without enough samples [1]")
    restarts: int = Field(description="starts of the observer [1]")
