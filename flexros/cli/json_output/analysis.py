"""JSON of the analysis of runs, and of imported logs."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from flexros.cli.json_output.base import Output


class Statistics(Output):
    """Statistics of an error, in the unit of its key."""

    max: float = Field(description="largest absolute value")
    rms: float = Field(description="root mean square")
    p95: float = Field(description="95th percentile of the absolute value")
    time_of_max_s: float = Field(description="time of the largest [s]")
    position_of_max_m: float | None = Field(default=None, description="place of the largest along the path [m]")
    samples: int = Field(description="samples [1]")


class PathErrors(Output):
    """Errors of the tool along its path."""

    shape: str = Field(description="shape of the path in words")
    axes: list[str] = Field(description="components in which it moves")
    length_m: float = Field(description="length of the path [m]")
    path_error_m: Statistics = Field(description="distance to the path [m]")
    time_synchronised_error_m: Statistics = Field(description="distance to the commanded position [m]")
    orientation_error_rad: Statistics | None = Field(
        default=None, description="angle to the commanded orientation [rad]"
    )
    chord_error_m: float = Field(description="possible distance of the path from the chords between its samples [m]")


class Performance(Output):
    """Path accuracy and repeatability (ISO 9283)."""

    cycles: int = Field(description="repetitions of the path [1]")
    points: int = Field(description="planes normal to the path that were crossed [1]")
    AT_p_m: float = Field(description="path accuracy [m]")
    RT_p_m: float | None = Field(default=None, description="path repeatability [m]")
    AT_abc_rad: list[float] | None = Field(default=None, description="accuracy of the orientation [rad]")
    RT_abc_rad: list[float] | None = Field(default=None, description="repeatability of the orientation [rad]")
    commanded_speed_m_per_s: float | None = Field(default=None, description="commanded speed [m/s]")
    AV: float | None = Field(default=None, description="velocity accuracy, relative [1]")
    RV: float | None = Field(default=None, description="velocity repeatability, relative [1]")


class StopFigures(Output):
    """A stop after a move."""

    time_s: float = Field(description="when the move ends [s]")
    positioning_time_s: float | None = Field(
        default=None, description="until the tool stays in the band about its target [s]"
    )
    settling_time_s: float | None = Field(
        default=None, description="until it stays in the band about its last position [s]"
    )
    stabilisation_time_s: float | None = Field(default=None, description="ISO 9283 [s]")
    overshoot_mm: float | None = Field(default=None, description="beyond the attained position [mm]")


class CornerFigures(Output):
    """A corner of the path."""

    point_m: list[float] = Field(description="the corner [m]")
    angle_rad: float = Field(description="change of direction [rad]")
    CR_m: float = Field(description="rounding [m]")
    CO_m: float = Field(description="overshoot [m]")


class MotorFigures(Output):
    """A motor: rad and Nm; m and N where it is linear."""

    tracking_error: Statistics | None = Field(default=None, description="reference minus measured position")
    torque_max: float | None = Field(default=None, description="largest absolute torque command")
    feedback_rms: float | None = Field(default=None, description="torque command minus feedforward, rms")
    feedback_share: float | None = Field(default=None, description="that over the rms of the command [1]")
    torque_limit: float | None = Field(default=None, description="limit of the torque")
    torque_limited_by: str | None = Field(default=None, description="where the limit is stated")
    saturated_share: float | None = Field(default=None, description="share of the samples at the limit [1]")
    overload_share: float | None = Field(
        default=None, description="share of the samples above a limit that is not enforced [1]"
    )
    link_deflection_max: float | None = Field(
        default=None, description="largest deflection of the gear, where the link side was measured"
    )


class LostSamples(Output):
    """Samples that are missing at a time."""

    time_s: float = Field(description="time before [s]")
    missing: int = Field(description="how many [1]")


class TopicFigures(Output):
    """Stamps of a topic."""

    count: int = Field(description="messages [1]")
    start_s: float = Field(description="first stamp since the start [s]")
    period_s: float | None = Field(default=None, description="usual period [s]")
    mean_period_s: float | None = Field(default=None, description="mean period [s]")
    jitter_std_s: float = Field(description="standard deviation of the stamps about an even grid [s]")
    jitter_p99_s: float = Field(description="99th percentile of that [s]")
    jitter_max_s: float = Field(description="largest of that [s]")
    missed: int = Field(description="missing samples [1]")
    gaps: list[LostSamples] = Field(description="where they are missing")
    duplicates: int = Field(description="repeated stamps [1]")
    out_of_order: int = Field(description="stamps before their predecessor [1]")
    exact: bool = Field(description="whether every stamp is on the grid")


class TimingFigures(Output):
    """Timing of the loop."""

    real_time: bool | None = Field(default=None, description="whether the wall clock paced it; none where not known")
    exact: bool = Field(description="no sample missing, every stamp exact")
    answered_share: float = Field(description="share of the measurements with a command of the same stamp [1]")
    states_without_command: int = Field(description="measurements without one [1]")
    commands_without_state: int = Field(description="commands without a measurement [1]")
    topics: dict[str, TopicFigures] = Field(description="by topic")
    received: dict[str, dict[str, Any]] = Field(description="times of receipt by topic, in real time")
    pacing: dict[str, Any] | None = Field(
        default=None, description="schedule of the plant, in real time: seconds, hertz, shares"
    )


class AnalysisOfRun(Output):
    """The analysis of a run; of several logs a list of them."""

    label: str = Field(description="name of the run")
    duration_s: float = Field(description="first to last measurement [s]")
    path: PathErrors | None = Field(default=None, description="none without tool topics")
    performance: Performance | None = Field(default=None, description="none without a path that moves")
    stops: list[StopFigures] = Field(description="stops after point-to-point moves")
    corners: list[CornerFigures] = Field(description="corners of the path")
    motors: dict[str, MotorFigures] = Field(description="by joint")
    timing: TimingFigures = Field(description="timing of the loop")
    frequency_responses: dict[str, Any] | None = Field(
        default=None, description="of an identification experiment, by position"
    )
    provenance: dict[str, Any] = Field(description="scenario, seed, versions, model hash")
    warnings: list[str] = Field(description="limits of these results")


class ImportedTopic(Output):
    """A topic of an imported log."""

    topic: str = Field(description="its name")
    joints: list[str] = Field(description="its joints")
    fields: list[str] = Field(description="recorded quantities")
    samples: int = Field(description="samples [1]")
    duration_s: float = Field(description="first to last sample [s]")
    rate_hz: float = Field(description="mean rate [Hz]")
    longest_interval_s: float = Field(description="longest time between two samples [s]")


class ImportedLog(Output):
    """A log of another recorder."""

    log: str | None = Field(default=None, description="folder that was written; none where only a mapping was proposed")
    mapping: str | None = Field(default=None, description="mapping that was proposed")
    assumptions: list[dict[str, Any]] | None = Field(
        default=None, description="what the proposal assumed: about, taken, ground, checked"
    )
    topics: list[ImportedTopic] = Field(description="what the log holds")
    warnings: list[str] = Field(description="what was left out or repaired")
