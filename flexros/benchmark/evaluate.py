"""Evaluation of a controller on all models: measures, cost V and demands."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.benchmark.demands import LimitCycles, StabilityDemands, demands
from flexros.benchmark.measures import Measures, mean, measures_of_run, worst
from flexros.benchmark.models import NOMINAL, RULES, benchmark_robot, set_values
from flexros.benchmark.simulation import NOISE, RegulatorSimulation
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import pandas as pd
    import plotly.graph_objects as go

    from flexros.arrays import FloatArray
    from flexros.benchmark.controllers import BenchmarkController
    from flexros.benchmark.demands import Demand
    from flexros.control.base import AbstractControlLaw

SEEDS = (1, 2, 3, 4, 5)
"""Seeds of the noise over which the measures are averaged."""


@dataclass(frozen=True, eq=False, repr=False)
class BenchmarkResult:
    """Result of a controller.

    Attributes:
        name: Name of the controller.
        noise: Standard deviation of the measurement noise [rad].
        seeds: Seeds of the noise.
        measures: Worst measures of each model set, mean over the seeds.
        costs: Cost V of each seed [1].
        demands: All demands with their verdicts; empty if they were not checked.
    """

    name: str
    noise: float
    seeds: tuple[int, ...]
    measures: dict[str, Measures]
    costs: tuple[float, ...]
    demands: tuple[Demand, ...]

    @property
    def cost(self) -> float:
        """Cost V, mean over the seeds [1]."""
        return total_cost(self.measures)

    @property
    def passed(self) -> bool:
        """Whether all demands are met."""
        return bool(self.demands) and all(demand.passed for demand in self.demands)

    def as_dict(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {
            "controller": self.name,
            "V": self.cost,
            "noise": self.noise,
            "seeds": list(self.seeds),
            "V_of_seeds": list(self.costs),
            "sets": {name: measures.as_dict() for name, measures in self.measures.items()},
            "demands": [demand.as_dict() for demand in self.demands],
            "passed": self.passed,
        }

    def to_pandas(self) -> pd.DataFrame:
        """Return cost V, its parts and the worst measures of each model set."""
        from flexros.benchmark.shown import measures_frame

        return measures_frame([self])

    def plot(self) -> go.Figure:
        """Draw the weighted costs of the model sets, whose sum is V."""
        from flexros.benchmark.shown import costs_figure

        return costs_figure([self])

    def __repr__(self) -> str:
        met = sum(demand.passed for demand in self.demands)
        return f"<BenchmarkResult of {self.name}: V = {self.cost:.5g}, {met} of {len(self.demands)} demands met>"

    def _repr_html_(self) -> str:
        from flexros.benchmark.shown import results_html

        return results_html([self])


def total_cost(measures: dict[str, Measures]) -> float:
    """Return the cost V = 0.6 V_nominal + 1.0 V_1 + 0.3 V_2 of the worst measures of each set [1]."""
    return float(sum(RULES[name].weight * measures[name].cost for name in RULES))


class FeedbackBenchmark:
    """The feedback benchmark of Moberg (2007), Paper C: same kinds of models and measures, not the original files.

    Plant, kinds of disturbances, measures and demands are those of the paper; model sets, noise, times and sizes of
    the disturbances are not public and were chosen, weights of the cost inferred from its Tables 1 and 2.

    Args:
        sensors: Sensors beside the motor encoder, see `SENSORS`.
        threads: Number of threads; default: one per processor.

    Raises:
        InputError: Unknown sensor.
    """

    def __init__(self, sensors: Sequence[str] = (), threads: int | None = None) -> None:
        self.sensors = tuple(sensors)
        self.robot = benchmark_robot(sensors)
        self._threads = threads
        self.simulation = RegulatorSimulation(self.robot)
        self.context = self.simulation.context

    @cached_property
    def stability(self) -> StabilityDemands:
        """Linear loops of all models."""
        return StabilityDemands(self.robot)

    @cached_property
    def _cycles(self) -> LimitCycles:
        return LimitCycles(self.robot)

    def evaluate(
        self,
        controller: BenchmarkController,
        *,
        noise: float = NOISE,
        seeds: Sequence[int] = SEEDS,
        progress: Callable[[str], None] | None = None,
    ) -> BenchmarkResult:
        """Evaluate a controller on all models and check its demands.

        Args:
            controller: The two controllers of the design.
            noise: Standard deviation of the white measurement noise [rad].
            seeds: Seeds of the noise; without noise only the first is run.
            progress: Called with the name of each step.

        Raises:
            InputError: Negative noise, no seed or a negative one, or a law that does not fit the robot.
        """
        check_noise(noise, seeds)
        tell = progress or (lambda _: None)
        of_sets: dict[str, list[Measures]] = {}
        for name in RULES:
            tell(f"runs of {name}")
            law = controller.nominal if name == NOMINAL else controller.perturbed
            of_sets[name] = self.measures_of_set(name, law, noise=noise, seeds=seeds)
        averages = {name: mean(runs) for name, runs in of_sets.items()}
        costs = tuple(total_cost(dict(zip(of_sets, runs, strict=True))) for runs in zip(*of_sets.values(), strict=True))
        tell("demands")
        checked = demands(controller, averages, self.stability, self._cycles, self._threads)
        used = tuple(seeds) if noise else tuple(seeds)[:1]
        return BenchmarkResult(controller.name, noise, used, averages, costs, checked)

    def measures_of_set(
        self, name: str, law: AbstractControlLaw, *, noise: float = NOISE, seeds: Sequence[int] = SEEDS
    ) -> list[Measures]:
        """Return the worst measures of a model set with a law, for every seed."""
        band, sample_time = RULES[name].band, self.robot.sample_time

        def figure(_: int, deflection: FloatArray, command: FloatArray) -> Measures:
            return measures_of_run(deflection, command, band, sample_time)

        values = set_values(self.robot, name)
        runs = self.simulation.run(law, values, figure, noise=noise, seeds=seeds, threads=self._threads)
        return [worst(models) for models in runs]


def check_noise(noise: float, seeds: Sequence[int]) -> None:
    """Check noise and seeds.

    Raises:
        InputError: The noise is negative or not finite, or there is no seed or a negative one.
    """
    if not (np.isfinite(noise) and noise >= 0.0):
        raise InputError(f"the noise is {noise} rad, allowed is zero or a positive number; correct it", "noise")
    if not seeds or min(seeds) < 0 or len(set(seeds)) != len(seeds):
        raise InputError(f"the seeds are {list(seeds)}, allowed are different numbers from 0 on; correct them", "seeds")
