"""JSON of design and benchmark of controllers."""

from __future__ import annotations

from pydantic import Field

from flexros.cli.json_output.base import Output


class Margins(Output):
    """Margins of the loop at one motor, the other loops closed; null for infinite."""

    plant: str = Field(description="the model")
    motor: str = Field(description="the motor")
    stable: bool = Field(description="whether the loop of all motors is stable")
    largest_eigenvalue: float = Field(description="largest absolute eigenvalue [1]")
    gain_margin: float | None = Field(default=None, description="smallest factor above 1 at which it is unstable [1]")
    lower_gain_margin: float = Field(description="largest factor below 1 at which it is unstable [1]")
    phase_margin_deg: float | None = Field(default=None, description="phase margin [deg]")
    delay_margin: float | None = Field(default=None, description="delay that makes it unstable [s]")
    crossover_hz: float = Field(description="highest frequency with a loop gain of 1 [Hz]")
    sensitivity: float = Field(description="largest |S| [1]")
    complementary_sensitivity: float = Field(description="largest |T| [1]")
    overshoot: float | None = Field(default=None, description="of a step of the reference [1]")
    settling: float | None = Field(default=None, description="time until a step stays within 2 % [s]")


class DesignedLoop(Output):
    """A controller with its loops."""

    order: int = Field(description="states of the controller [1]")
    margins: list[Margins] = Field(description="of every plant and motor")


class Designed(Output):
    """A design: what the method guarantees, and the controllers by name."""

    figures: dict[str, float] = Field(description="figures of the method, e.g. gamma")
    controllers: dict[str, DesignedLoop] = Field(description="C1 and C2, or controller")


class MethodEntry(Output):
    """A method of design."""

    description: str = Field(description="what it is")
    choices: dict[str, str] = Field(description="its choices with their units")


class ControllerEntry(Output):
    """A built-in controller of the benchmark."""

    name: str = Field(description="its name")
    description: str = Field(description="what it is")


class SetMeasures(Output):
    """Worst measures of a model set (Paper C, section 5.3)."""

    e: list[float] = Field(description="tool deflections e1 to e8 [mm]")
    Ts: list[float] = Field(description="settling times [s]")
    T_NOISE: float = Field(description="torque due to noise, peak to peak [Nm]")
    T_MAX: float = Field(description="largest torque [Nm]")
    T_RMS: float = Field(description="rms of the torque [Nm]")
    V: float = Field(description="cost of the set [1]")


class DemandVerdict(Output):
    """A demand; the value must be below the limit."""

    name: str = Field(description="what is demanded")
    value: float | None = Field(default=None, description="worst value, in `unit`")
    limit: float = Field(description="limit, in `unit`")
    unit: str = Field(description="unit of both")
    passed: bool = Field(description="whether it is met")
    where: str = Field(description="model and spring segment of the worst value")


class Benchmarked(Output):
    """A controller on the feedback benchmark; of several a list of them."""

    controller: str = Field(description="its name")
    V: float = Field(description="cost, mean over the seeds [1]")
    noise: float = Field(description="measurement noise, standard deviation [rad]")
    seeds: list[int] = Field(description="seeds of the noise")
    V_of_seeds: list[float] = Field(description="cost of each seed [1]")
    sets: dict[str, SetMeasures] = Field(description="by model set")
    demands: list[DemandVerdict] = Field(description="all demands")
    passed: bool = Field(description="whether all are met")


class MotionMeasures(Output):
    """Worst measures of a model set on a robot of several axes."""

    e: list[float] = Field(description="tool deflections, by window [mm]")
    Ts: list[float] = Field(description="settling times, by window that settles [s]")
    T_NOISE: float = Field(description="torque due to noise, peak to peak, largest motor [% of its torque]")
    T_MAX: float = Field(description="largest torque, largest motor [% of its torque]")
    V: float = Field(description="cost of the set [1]")


class BenchmarkedOnRobot(Output):
    """A controller on the multivariable benchmark; of several a list of them."""

    controller: str = Field(description="its name")
    robot: str = Field(description="e12 or six_axis")
    V: float = Field(description="cost, mean over the seeds [1]")
    seeds: list[int] = Field(description="seeds of the noise")
    sets: dict[str, MotionMeasures] = Field(description="by model set")
    demands: list[DemandVerdict] = Field(description="all demands")
    passed: bool = Field(description="whether all are met")


class BenchmarkLog(Output):
    """Measures of a log of the scenario feedback_benchmark."""

    controller: str = Field(description="name of the log")
    sets: dict[str, SetMeasures] = Field(description="of the nominal model")
