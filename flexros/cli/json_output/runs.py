"""JSON of the commands that run scenarios."""

from __future__ import annotations

from pydantic import Field

from flexros.cli.json_output.base import OpenOutput, Output


class ScenarioEntry(Output):
    """A built-in scenario."""

    name: str = Field(description="its name")
    robot: str = Field(description="its robot")
    description: str = Field(description="its purpose")


class RunOutcome(OpenOutput):
    """The outcome of a run; further keys are figures of the transport, with the unit in the name."""

    exit_code: int = Field(description="0 done, 3 aborted, 130 interrupted")
    message: str = Field(description="what happened; empty when done")
    transport: str = Field(description="direct, or ros with its layout")
    log: str | None = Field(default=None, description="folder of the log")
    samples: int = Field(description="samples of the loop [1]")
    simulated_time_s: float = Field(description="samples times the sample time [s]")
    wall_time_s: float = Field(description="time that the loop took [s]")
    warnings: list[str] | None = Field(default=None, description="what the feedforward cannot compensate")


class Learned(Output):
    """Iterative learning control."""

    max_mm: list[float] = Field(description="largest tool error of each run [mm]")
    rms_mm: list[float] = Field(description="rms of the tool error of each run [mm]")


class FastestMove(Output):
    """One time-optimal move."""

    rigid_duration_s: float = Field(description="duration of the fastest motion of the rigid arm [s]")
    duration_s: float = Field(description="duration of the smooth motion [s]")
    at_limit: dict[str, float] = Field(
        description="share of the rigid duration for which the torque of each motor, or speed, is at its limit [1]"
    )
    smoothing_s: float = Field(description="time over which a step of the acceleration is spread [s]")
    slowed_by: float = Field(description="factor by which the smooth motion was slowed down as a whole [1]")
    excess: float = Field(description="largest excess over a limit, relative to it [1]")


class Replayed(OpenOutput):
    """A replay; further keys are figures, messages by topic among them."""

    exit_code: int = Field(description="0 done, 3 aborted, 130 interrupted")
    message: str = Field(description="what happened; empty when done")
    warnings: list[str] = Field(description="what is doubtful")
