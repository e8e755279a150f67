"""Demands on a controller, each with value, limit and verdict (Moberg 2007, Paper C, section 5.6)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.benchmark.measures import oscillation
from flexros.benchmark.models import NOMINAL, PARAMETERS, RULES, model_names, set_values
from flexros.benchmark.simulation import QUIET, RegulatorSimulation
from flexros.control.context import LoopContext
from flexros.control.design.closed_loop import largest_eigenvalues
from flexros.control.design.plants import linear_plants, sampled_plants
from flexros.control.linear_controller import linear_controller
from flexros.simulate.plant_model import PlantModel

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from flexros.arrays import FloatArray
    from flexros.benchmark.controllers import BenchmarkController
    from flexros.benchmark.measures import Measures
    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.plants import SampledPlants
    from flexros.robot import Robot

NOISE_TORQUE = 5.0
"""Largest peak-to-peak torque caused by noise [Nm]."""
LOOP_GAIN = 2.5
"""Factor on the loop gain at which the nominal model must be stable [1]."""
LONG_DELAY = 2e-3
"""Delay at which the nominal model must be stable, instead of 0.5 ms [s]."""
LIMIT_CYCLE = 0.01
"""Largest limit cycle, peak-to-peak at the tool [mm]."""
WATCHED = 1.0
"""Time at the end of a quiet run in which a limit cycle is measured about its trend [s], chosen."""


@dataclass(frozen=True)
class Demand:
    """A demand and its verdict; the value must be below the limit.

    Attributes:
        name: What is demanded.
        value: Value of the controller, the worst over models.
        limit: Limit.
        unit: Unit of both.
        passed: Whether it is met.
        where: Model and spring segment of the worst value.
    """

    name: str
    value: float
    limit: float
    unit: str
    passed: bool
    where: str = ""

    @classmethod
    def below(cls, name: str, value: float, limit: float, unit: str, where: str = "") -> Demand:
        """Return a demand that is met by a finite value below the limit."""
        return cls(name, value, limit, unit, bool(np.isfinite(value) and value < limit), where)

    def as_dict(self) -> dict[str, Any]:
        """Return the demand for JSON."""
        return asdict(self)


class StabilityDemands:
    """Stability of the linear loops of all models in every segment of the gear's spring, with delay and sampling.

    Args:
        robot: The robot of the benchmark.
    """

    def __init__(self, robot: Robot) -> None:
        self._context = LoopContext(robot, robot.sample_time)
        sensors = robot.further_sensors
        further = PlantModel(robot, (), PARAMETERS, sensors=sensors).further if sensors else None
        self._plants = {
            name: sampled_plants(
                linear_plants(robot, names=PARAMETERS, values=set_values(robot, name), label=name, further=further),
                robot.sample_time,
                robot.delay,
            )
            for name in RULES
        }
        nominal = linear_plants(
            robot, names=PARAMETERS, values=set_values(robot, NOMINAL), label=NOMINAL, further=further
        )
        self._delayed = sampled_plants(nominal, robot.sample_time, LONG_DELAY)

    @property
    def nominal(self) -> SampledPlants:
        """The nominal model in all spring segments."""
        return self._plants[NOMINAL]

    def eigenvalues(self, law: AbstractControlLaw, nominal_only: bool) -> dict[str, tuple[float, str]]:
        """Return the largest absolute eigenvalue of each demand with the loop where it occurs.

        Args:
            law: The control law.
            nominal_only: Whether it is the controller C1 of the nominal model alone; C2 has to
                hold the sets M1 and M2 as well.
        """
        controller = linear_controller(law, self._context)
        found = {f"stability, {name}": self._largest(plants, controller) for name, plants in self._plants.items()
                 if name == NOMINAL or not nominal_only}  # fmt: skip
        found[f"stability, loop gain x {LOOP_GAIN:g}"] = self._largest(self.nominal, controller, LOOP_GAIN)
        found[f"stability, delay {1e3 * LONG_DELAY:g} ms"] = self._largest(self._delayed, controller)
        return found

    @staticmethod
    def _largest(plants: SampledPlants, controller: Any, gain: float = 1.0) -> tuple[float, str]:
        radii = largest_eigenvalues(plants, controller, gain)
        worst = int(np.argmax(radii))
        return float(radii[worst]), plants.labels[worst]


class LimitCycles:
    """Limit cycles in runs without noise, followed by a quiet time.

    Args:
        robot: The robot of the benchmark.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._watched = round(WATCHED / robot.sample_time)
        late = robot.with_values({"delay": LONG_DELAY}, "the benchmark")
        self._plain = RegulatorSimulation(robot, quiet=QUIET)
        self._gained = RegulatorSimulation(robot, quiet=QUIET, loop_gain=LOOP_GAIN)
        self._late = RegulatorSimulation(late, quiet=QUIET)

    def of(self, controller: BenchmarkController, threads: int | None = None) -> Iterator[Demand]:
        """Yield the demands on limit cycles of both controllers."""
        for name in RULES:
            law = controller.nominal if name == NOMINAL else controller.perturbed
            value, model = self._largest(self._plain, law, set_values(self._robot, name), threads)
            yield Demand.below(f"limit cycle, {name}", value, LIMIT_CYCLE, "mm", model_names(name)[model])
        nominal = set_values(self._robot, NOMINAL)
        for which, law in _both(controller).items():
            for text, simulation in (
                (f"loop gain x {LOOP_GAIN:g}", self._gained),
                (f"delay {1e3 * LONG_DELAY:g} ms", self._late),
            ):
                value, _ = self._largest(simulation, law, nominal, threads)
                yield Demand.below(f"limit cycle, {text}, {which}", value, LIMIT_CYCLE, "mm", NOMINAL)

    def _largest(
        self, simulation: RegulatorSimulation, law: AbstractControlLaw, values: FloatArray, threads: int | None
    ) -> tuple[float, int]:
        def cycle(_: int, deflection: FloatArray, command: FloatArray) -> float:
            return oscillation(deflection[-self._watched :])

        cycles = simulation.run(law, values, cycle, threads=threads)[0]
        return float(np.max(cycles)), int(np.argmax(cycles))


def demands(
    controller: BenchmarkController,
    measures: Mapping[str, Measures],
    stability: StabilityDemands,
    cycles: LimitCycles,
    threads: int | None = None,
) -> tuple[Demand, ...]:
    """Check all demands on a controller.

    Args:
        controller: The controller.
        measures: Worst measures of each model set.
        stability: Linear loops of all models.
        cycles: Runs without noise.
        threads: Number of threads; default: one per processor.
    """
    found = []
    for name, rules in RULES.items():
        found.append(Demand.below(f"settling, {name}", float(np.max(measures[name].settling)), rules.deadline, "s"))
    for name in RULES:
        found.append(Demand.below(f"noise torque, {name}", measures[name].noise_torque, NOISE_TORQUE, "Nm"))
    for which, law in _both(controller).items():
        for name, (value, where) in stability.eigenvalues(law, nominal_only=which == "C1").items():
            found.append(Demand.below(f"{name}, {which}", value, 1.0, "1", where))
    return (*found, *cycles.of(controller, threads))


def _both(controller: BenchmarkController) -> dict[str, AbstractControlLaw]:
    return {"C1": controller.nominal, "C2": controller.perturbed}
