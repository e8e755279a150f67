"""JSON of the commands that identify."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from flexros.cli.json_output.base import Output


class ResponseFigures(Output):
    """Frequency response of one position."""

    gears: list[float] = Field(description="gear coordinates [rad or m]")
    lines: int = Field(description="excited frequencies [1]")
    lowest_hz: float = Field(description="lowest [Hz]")
    highest_hz: float = Field(description="highest [Hz]")
    blocks: int = Field(description="blocks of experiments [1]")
    periods: int = Field(description="periods of each [1]")
    relative_std_diagonal: dict[str, float | None] = Field(
        description="standard deviation over magnitude, median of the lines, by output [1]"
    )
    warnings: list[str] = Field(description="findings in the record")
    relative_std: dict[str, float] | None = Field(
        default=None, description="median over all elements, total and noise alone [1]"
    )


class IdentifiedParameter(Output):
    """A fitted parameter, in `unit`."""

    name: str = Field(description="its name in the robot")
    unit: str = Field(description="SI unit")
    nominal: float = Field(description="value before")
    value: float = Field(description="fitted value")
    relative_std: float | None = Field(default=None, description="standard deviation over the value [1]")
    interval_95: list[float | None] = Field(description="ends of the 95 % interval; none where unknown")
    verdict: str = Field(description="determined, weak or not_determined")
    reason: str = Field(description="why")
    used: bool = Field(description="whether identified.yaml has it")
    truth: float | None = Field(default=None, description="true value of a simulated robot")


class Identified(Output):
    """Parameters fitted to frequency responses."""

    schema_version: int = Field(description="version of this record", alias="schema")
    robot: str = Field(description="name of the robot")
    estimator: str = Field(description="LLS, LLSM or NLS")
    weights: str = Field(description="user, optimal or combined")
    verdict: str = Field(description="in a sentence")
    cost: dict[str, float] = Field(description="cost of nominal and identified values [1]")
    covariance: dict[str, Any] = Field(description="what the intervals rest on")
    bias_signs: list[str] = Field(description="signs of a form error of the model")
    advice: str = Field(description="what to do; empty for nothing")
    parameters: list[IdentifiedParameter] = Field(description="all unknowns")
    not_determined: list[dict[str, Any]] = Field(description="combinations that the responses do not determine")
    kept_nominal: list[str] = Field(description="parameters whose fitted value is not used")
    starts: dict[str, Any] = Field(description="fits from all initial values")
    positions: list[list[float]] = Field(description="gear coordinates of each position [rad or m]")
    experiment: dict[str, Any] | None = Field(default=None, description="effort of the experiment, where known")
    warnings: list[str] = Field(description="limits of the result")
    provenance: dict[str, Any] = Field(description="origin of the data")
    run: dict[str, Any] | None = Field(default=None, description="outcome of the run, of identify robot alone")


class DesignedExperiment(Output):
    """Positions of an identification experiment."""

    positions: list[list[float]] = Field(description="gear coordinates [rad or m]")
    shares: list[int] = Field(description="how often each is visited [1]")
    candidates: int = Field(description="positions to choose from [1]")
    origin: str = Field(description="where they come from")
    remark: str = Field(description="what the design says of itself")
    refused: dict[str, int] = Field(description="candidates that were refused, by reason [1]")
    duality_gap: float = Field(description="of the optimal design [1]")
    optimal_support: int = Field(description="positions of the optimal design [1]")
    efficiency: float = Field(description="information over that of the optimal design [1]")
    random_efficiency: dict[str, float] = Field(description="the same of random positions [1]")
    relative_std_of: str = Field(description="what the deviations are of")
    relative_std: dict[str, float | None] = Field(
        description="expected standard deviation over value, by parameter [1]"
    )
    random_relative_std: dict[str, float | None] = Field(description="the same of random positions [1]")
    amplitude_factor: float = Field(description="factor on the amplitudes of the template [1]")
    duration_s: float = Field(description="robot time [s]")


class FrictionPoint(Output):
    """Friction at a constant speed."""

    speed: float = Field(description="speed [rad/s or m/s]")
    torque: float = Field(description="friction torque [Nm or N]")
    std: float = Field(description="its standard deviation [Nm or N]")


class FrictionMeasured(Output):
    """Friction at constant speeds, and the laws fitted to it."""

    joint: str = Field(description="the motor")
    points: list[FrictionPoint] = Field(description="by speed")
    offset: float = Field(description="torque that both directions share [Nm or N]")
    laws: list[dict[str, Any]] = Field(description="fitted laws with parameters and information")
    best: str | None = Field(default=None, description="law with the best information; none where no law was fitted")
