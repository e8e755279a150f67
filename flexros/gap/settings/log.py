"""What a log shows: its noise, prediction errors of a model, and the locations of a gap."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flexros.config.settings import Settings


class NoiseSettings(Settings):
    """Settings of the encoder noise that a log shows."""

    still: float = Field(default=0.25, gt=0, description="shortest standstill that noise is measured in [s]")
    still_samples: int = Field(
        default=400, ge=1, description="samples at standstill from which noise is measured there, else above the band"
    )
    differs: float = Field(
        default=0.2, gt=0, description="relative difference from the robot file from which a warning is given [1]"
    )
    as_declared: float = Field(
        default=0.06, ge=0, description="relative difference up to which noise counts as that of the robot file [1]"
    )
    implausible: float = Field(
        default=0.3,
        ge=0,
        description="measured over declared noise below which positions of a real machine were filtered or rounded, so "
        "that the declared noise is used [1]",
    )
    measured_error: float = Field(
        default=0.01,
        ge=0,
        description="relative error of the variance of measured white noise (tuned on development seeds) [1]",
    )
    coloured_error: float = Field(
        default=0.03, ge=0, description="the same of coloured noise (tuned on development seeds) [1]"
    )
    rounding_error: float = Field(
        default=0.1,
        ge=0,
        description="relative error of the variance of quantization, which is not white where a motor is slow [1]",
    )
    coarse_step: float = Field(
        default=6.0,
        gt=0,
        description="step of an encoder over its declared noise, rms, from which rounding is an effect; finer steps "
        "are a property of the sensor and part of its noise; a declared noise that is rounding alone is 3.5 times "
        "smaller than its step [1]",
    )
    doubt: float = Field(
        default=0.5,
        ge=0,
        description="error of the variance over the difference between the noise of a log and the noise assumed [1]",
    )
    signal_tolerance: float = Field(
        default=0.05,
        ge=0,
        description="share of the rms of a torque that counts as no gap, for logs of real machines, where nothing was "
        "repeated [1]",
    )


class RigidArmSettings(Settings):
    """Settings of how much is taken of a real machine's log of torques where the model has no springs."""

    plenty: int = Field(
        default=36_000,
        ge=1000,
        description="samples of all motors together above which the rate is lowered by a whole factor: the mean torque "
        "of a sample moves a rigid arm as its course does",
    )
    lowest_rate: float = Field(default=200.0, gt=0, description="lowest rate [Hz] (chosen)")
    most_values: int = Field(
        default=120_000,
        ge=1000,
        description="most samples of all motors together that are fitted or held out then; of a longer log the most "
        "informative part",
    )


class ResidualSettings(Settings):
    """Settings of the weighted prediction errors."""

    starting_level: float = Field(
        default=0.3,
        gt=0,
        description="relative torque noise of the predictor that finds the initial state of a log that begins in "
        "motion [1]",
    )
    settles_within: float = Field(
        default=0.25,
        gt=0,
        description="part of a simulated log within which the predictor's gain settles; its torque noise is doubled "
        "until it does, because the gain holds near one pose [1]",
    )
    far_off: float = Field(
        default=1e4,
        gt=0,
        description="mean squared prediction error over its floor from which on the nominal model is far off: the "
        "predictor follows the encoders more closely then, in steps of ten of its torque noise up to `starting_level`, "
        "and if that does not help, the search begins with what the torques show, as on a real machine [1]",
    )
    at_rest: float = Field(
        default=10.0,
        gt=0,
        description="prediction errors from rest, over their noise, up to which a log begins at rest [1]",
    )
    lost_commands: float = Field(
        default=20.0,
        ge=0,
        description="decrease of the weighted sum of squares from which short holes in the commands are lost commands, "
        "not held ones [1]",
    )
    least_left: float = Field(
        default=0.3, gt=0, le=1, description="share of a log that unknown torques must leave for the fit [1]"
    )
    enough_left: int = Field(
        default=1000, ge=1, description="samples that are enough for the fit, however small their share is (chosen)"
    )
    tool_poses: int = Field(
        default=10_000, ge=10, description="largest number of tool poses used; of more, every second, third ... is"
    )
    sensor_values: int = Field(
        default=100_000,
        ge=100,
        description="largest number of values of all further sensors together; of more, every second, third ... is",
    )


class WhereSettings(Settings):
    """Settings of the search for the locations of a gap."""

    realisations: int = Field(default=200, ge=20, description="simulated logs without a gap, for p-values [1]")
    floor: Literal["estimated", "predicted"] = Field(
        default="estimated",
        description="level of the noise: estimated from the highest octave of the log, or the standard deviations of "
        "the predictor",
    )
    lowest_hz: float = Field(default=2.0, gt=0, description="least upper end of the lowest octave band [Hz]")
    orders: float = Field(default=60.0, gt=1, description="highest order evaluated [periods per turn of the rotor]")
    least_freedom: float = Field(
        default=8.0, gt=0, description="degrees of freedom that a location needs to be tested [1]"
    )
    significant: float = Field(
        default=0.05, gt=0, lt=1, description="p-value up to which a location is significant [1]"
    )
    least_share: float = Field(
        default=0.02, ge=0, lt=1, description="share of the excess from which a location is reported [1]"
    )
    least_order_share: float = Field(
        default=0.01,
        ge=0,
        lt=1,
        description="the same for an order, which shows only while the rotor turns [1]",
    )
    least_score: float = Field(
        default=0.02,
        ge=0,
        description="concentration from which a location is reported, so that evenly spread excess names no regime "
        "[nats]",
    )
    most: int = Field(default=12, ge=1, description="largest number of locations reported [1]")
