"""JSON of the rigid regression, the identification of one axis, and that of the kinematics."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from flexros.cli.json_output.base import Output


class RigidVerdict(Output):
    """Whether a regression can be used."""

    usable: bool = Field(description="whether identified.yaml was written from it")
    sentence: str = Field(description="why, one sentence")
    largest_error_percent: float = Field(description="largest torque error with which it can [%]")


class RegressionParameter(Output):
    """A combination of parameters that the motion determines."""

    name: str = Field(description="name of the combination")
    words: str = Field(description="what it is")
    combination: dict[str, float] = Field(description="its parameters with their factors")
    value: float = Field(description="estimate, in `unit`")
    std: float | None = Field(default=None, description="standard deviation, in `unit`; none where not estimated")
    relative_std_percent: float | None = Field(default=None, description="that over the value [%]")
    unit: str = Field(description="SI unit")
    nominal: float = Field(description="value of the nominal model, in `unit`")
    estimated: bool = Field(description="whether the motion shows it; else it keeps its nominal value")


class NotExcited(Output):
    """A combination that the motion does not show."""

    name: str = Field(description="name of the combination")
    reason: str = Field(description="why")


class Excitation(Output):
    """What the motion shows of the robot."""

    rich_enough: bool = Field(description="whether the condition number is small enough")
    condition_number: float | None = Field(default=None, description="of the scaled regressor [1]")
    largest_condition_number: float = Field(description="largest that is accepted [1]")
    not_excited: list[NotExcited] = Field(description="combinations that the motion does not show")
    motors_that_stood_still: list[str] = Field(description="names of motors")
    without_effect_in_any_motion: list[str] = Field(description="parameters that no motion can show")


class TorqueErrorOfLog(Output):
    """Torque that the model leaves on one log, rms over rms of the torque."""

    log: str = Field(description="name of the log")
    total: float | None = Field(default=None, description="of all motors [%]")
    motors: dict[str, float | None] = Field(description="by motor; none where its torque is zero [%]")
    rows: int = Field(description="rows of the regression [1]")


class ForceErrors(Output):
    """Torque errors of a regression."""

    fit: TorqueErrorOfLog = Field(description="on the logs of the fit")
    fit_with_hold: float | None = Field(default=None, description="with commands as held, where this was compared [%]")
    robot_file: float | None = Field(default=None, description="of identified.yaml, without what it cannot hold [%]")
    cross_tests: list[TorqueErrorOfLog] = Field(description="on logs that were not fitted")


class ValueWithUnit(Output):
    """A value of a robot file."""

    value: float = Field(description="value, in `unit`")
    std: float | None = Field(default=None, description="standard deviation, in `unit`")
    unit: str = Field(description="SI unit")


class FrictionOutside(Output):
    """Friction that a robot file does not hold."""

    values: dict[str, float] = Field(description="by combination [SI]")
    effects: list[str] = Field(description="the same as effects")


class RigidIdentified(Output):
    """A rigid model by linear regression; also the file rigid.json."""

    schema_version: int = Field(description="version of this record", alias="schema")
    verdict: RigidVerdict = Field(description="whether it can be used")
    robot: str = Field(description="name of the nominal robot")
    settings: dict[str, Any] = Field(description="settings of the regression")
    torque: str = Field(description="measured or command")
    cutoff_hz: float = Field(description="cut-off of the filters [Hz]")
    rate_hz: float = Field(description="rate of the rows [Hz]")
    rows: int = Field(description="rows of the regression [1]")
    parameters: list[RegressionParameter] = Field(description="all combinations")
    excitation: Excitation = Field(description="what the motion shows")
    force_error_percent: ForceErrors = Field(description="torque that the model leaves")
    identified_values: dict[str, ValueWithUnit] = Field(description="values of identified.yaml by parameter")
    left_at_nominal: dict[str, str] = Field(description="motors and bodies that keep nominal values, with the reason")
    not_met: dict[str, float] = Field(description="combinations that no physical body has, with what is left [SI]")
    not_in_robot_file: FrictionOutside = Field(description="what the robot file cannot hold")
    means_in_robot_file: list[str] = Field(description="where the robot file has the mean of two values, sentences")
    warnings: list[str] = Field(description="limits of the result")
    provenance: dict[str, Any] = Field(description="versions, hash of the model, origin of the logs")


class AxisParameter(Output):
    """A parameter of the model of one axis."""

    name: str = Field(description="its name")
    value: float = Field(description="estimate, in `unit`")
    std: float | None = Field(default=None, description="standard deviation, in `unit`; none where not determined")
    interval: list[float] | None = Field(default=None, description="ends of the 95 % interval, in `unit`")
    unit: str = Field(description="SI unit")


class AxisQuality(Output):
    """How well a model of one axis fits a log."""

    prediction_error_rms: float | None = Field(default=None, description="one sample ahead, in the unit of the output")
    prediction_percent: float | None = Field(default=None, description="fit one sample ahead, 100 is perfect [%]")
    simulation_percent: float | None = Field(default=None, description="fit of the simulation, 100 is perfect [%]")


class AxisModel(Output):
    """A fitted model of one axis."""

    parameters: list[AxisParameter] = Field(description="all parameters")
    fit: AxisQuality = Field(description="on the log of the fit")
    validation: AxisQuality | None = Field(default=None, description="on the log that was not fitted")
    error_correlation: float | None = Field(default=None, description="of neighbouring prediction errors [1]")
    converged: bool = Field(description="whether the search converged")


class AxisIdentified(Output):
    """A model of one axis, nonlinear and linear; also the file axis.json."""

    schema_version: int = Field(description="version of this record", alias="schema")
    joint: str = Field(description="the motor")
    structure: dict[str, Any] = Field(description="masses, gear law and friction of the nonlinear model")
    antiresonances_hz: list[float] = Field(description="from which the search started [Hz]")
    resonances_hz: list[float] = Field(description="from which the search started [Hz]")
    frequencies_from: str = Field(description="where these come from")
    start: dict[str, float] = Field(description="initial values of the search [SI]")
    nonlinear: AxisModel = Field(description="model with nonlinear gear and friction")
    linear: AxisModel = Field(description="the same with a linear gear")
    gain: float | None = Field(default=None, description="by how many points the nonlinear model simulates better [%]")
    gain_on: str = Field(description="fit or validation")
    warnings: list[str] = Field(description="limits of the result")
    provenance: dict[str, Any] = Field(description="versions, origin of the logs")


class Accuracy(Output):
    """Distances of measured from computed tool positions."""

    mean_mm: float = Field(description="mean [mm]")
    three_sigma_mm: float = Field(description="mean plus three standard deviations, as of ISO 9283 [mm]")
    max_mm: float = Field(description="largest [mm]")


class BeforeAndAfter(Output):
    """Accuracy with the nominal and with the identified robot."""

    poses: int | None = Field(default=None, description="poses that were not fitted [1]")
    before: Accuracy = Field(description="nominal robot")
    after: Accuracy = Field(description="identified robot")


class KinematicParameter(Output):
    """A length, angle, encoder zero or compliance."""

    name: str = Field(description="its name in the robot")
    nominal: float = Field(description="value before, in `unit`")
    value: float = Field(description="identified value, in `unit`")
    interval: list[float] = Field(description="ends of the 95 % interval, in `unit`")
    unit: str = Field(description="SI unit")
    determined: bool = Field(description="whether the poses determine it")


class KinematicIdentified(Output):
    """Lengths, angles, zeros and compliances; also the file kinematics.json."""

    robot: str = Field(description="name of the nominal robot")
    poses: int = Field(description="fitted poses [1]")
    noise: float = Field(description="noise of the tracker, rms [m]")
    fit: BeforeAndAfter = Field(description="on the fitted poses")
    validation: BeforeAndAfter | None = Field(default=None, description="on poses that were not fitted")
    parameters: list[KinematicParameter] = Field(description="all unknowns")


class PosesPlanned(Output):
    """The most informative poses, chosen instead of a fit."""

    poses: int = Field(description="poses [1]")
    file: str = Field(description="CSV file of the poses")
