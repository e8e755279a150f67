"""Evaluation of a controller on the multivariable benchmark: measures, cost V and demands of 21 models."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.benchmark.controllers import load_controller
from flexros.benchmark.demands import Demand
from flexros.benchmark.models import NOMINAL, RULES
from flexros.benchmark.multivariable.measures import (
    MotionMeasures,
    lost_run,
    mean_motion,
    measures_of_motion,
    worst_motion,
)
from flexros.benchmark.multivariable.problem import SEED, highest
from flexros.control.design.closed_loop import largest_eigenvalues
from flexros.control.design.plants import linear_plants, sampled_plants
from flexros.control.linear_controller import linear_controller
from flexros.errors import InputError
from flexros.scenario.batch import batch, whole_record
from flexros.scenario.experiment import Experiment

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.benchmark.controllers import BenchmarkController
    from flexros.benchmark.multivariable.problem import Problem
    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.plants import SampledPlants
    from flexros.scenario.batch import RunRecord

SETTLED = 1.0
"""Largest settling time [s] (chosen)."""
NOISE_SHARE, TORQUE_SHARE = 5.0, 100.0
"""Largest torque by noise, peak-to-peak, and largest torque of a motor [% of its torque] (chosen)."""
LOOP_GAIN, LONG_DELAY = 2.0, 1e-3
"""Factor on the loop gain, and delay [s], with which the nominal model must be stable (chosen)."""
_LIBRARY = Path(__file__).parent / "library"


@dataclass(frozen=True, eq=False)
class MotionResult:
    """Result of a controller.

    Attributes:
        name: Name of the controller.
        robot: Name of the robot.
        seeds: Seeds of the noise.
        measures: Worst measures of each model set, mean over the seeds.
        demands: All demands with their verdicts.
    """

    name: str
    robot: str
    seeds: tuple[int, ...]
    measures: dict[str, MotionMeasures]
    demands: tuple[Demand, ...]

    @property
    def cost(self) -> float:
        """Cost V = 0.6 V_nominal + 1.0 V_M1 + 0.3 V_M2 [1]."""
        return motion_cost(self.measures)

    def as_dict(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {
            "controller": self.name,
            "robot": self.robot,
            "V": self.cost,
            "seeds": list(self.seeds),
            "sets": {name: measures.as_dict() for name, measures in self.measures.items()},
            "demands": [demand.as_dict() for demand in self.demands],
            "passed": all(demand.passed for demand in self.demands),
        }


@dataclass(frozen=True, eq=False)
class MotionRun:
    """A run of the nominal model.

    Attributes:
        time: Time [s], shape (n,).
        distance: Distance of the tool from its undisturbed path [mm], shape (n,).
        torque: Largest torque of a motor [% of its torque], shape (n,).
    """

    time: FloatArray
    distance: FloatArray
    torque: FloatArray


def motion_cost(measures: dict[str, MotionMeasures]) -> float:
    """Return the cost V of the worst measures of each set [1]."""
    return float(sum(RULES[name].weight * found.cost for name, found in measures.items()))


def motion_controller_names(problem: Problem) -> tuple[str, ...]:
    """Return the names of the built-in controllers of a problem."""
    return tuple(sorted(path.stem for path in (_LIBRARY / problem.name).glob("*.yaml")))


def load_motion_controller(problem: Problem, name_or_path: str) -> BenchmarkController:
    """Load a built-in controller of a problem by its name, or a file of a user.

    Raises:
        InputError: Unknown name, or a malformed file.
    """
    if name_or_path in motion_controller_names(problem):
        return load_controller(_LIBRARY / problem.name / f"{name_or_path}.yaml")
    if not name_or_path.endswith((".yaml", ".yml", ".py")) and "/" not in name_or_path:
        raise InputError(
            f"unknown controller '{name_or_path}' for {problem.name}; there are "
            f"{', '.join(motion_controller_names(problem))}, or the path of a .yaml or .py file"
        )
    return load_controller(name_or_path)


class MotionBenchmark:
    """The multivariable benchmark: disturbances at tool and motors, and a moving reference, on a robot of several axes.

    The rules are those of the feedback benchmark (Moberg 2007, Paper C); the thesis asks for a multivariable one with
    parametric uncertainty (section 6.2). All numbers are chosen. The references and torques of the DAE feedforward
    belong to the problem and come from the nominal model.

    Args:
        problem: The problem.
        threads: Number of threads; default: one per processor.
        seed: Seed of the random models.
    """

    def __init__(self, problem: Problem, threads: int | None = None, seed: int = SEED) -> None:
        self.problem = problem
        self._threads, self._seed = threads, seed
        self._prepared = Experiment.prepare(problem.scenario)

    @property
    def sample_time(self) -> float:
        """Time between two samples [s]."""
        return self._prepared.sample_time

    def evaluate(
        self,
        controller: BenchmarkController,
        *,
        noise: bool = True,
        seeds: Sequence[int] = (1, 2),
        progress: Callable[[str], None] | None = None,
    ) -> MotionResult:
        """Evaluate a controller on all models and check its demands.

        Args:
            controller: The controllers of the nominal and of the perturbed models.
            noise: Whether the encoders have the noise of the robot.
            seeds: Seeds of the noise; without noise only the first is run.
            progress: Called with the name of each step.

        Raises:
            InputError: A law does not fit the robot.
        """
        if controller.sensors:
            raise InputError(
                f"controller {controller.name} uses {', '.join(controller.sensors)}, but {self.problem.name} is "
                "measured by its motor encoders alone; remove the key sensors"
            )
        tell = progress or (lambda _: None)
        used = tuple(seeds) if noise else tuple(seeds)[:1]
        found = {}
        for name in RULES:
            tell(f"runs of {name}")
            law = controller.nominal if name == NOMINAL else controller.perturbed
            found[name] = self.measures_of_set(name, law, noise=noise, seeds=used)
        tell("demands")
        return MotionResult(controller.name, self.problem.name, used, found, self._demands(controller, found))

    def experiment(self, law: AbstractControlLaw, *, noise: bool = True) -> Experiment:
        """Return the run of the nominal model with a law; all laws share its reference.

        Args:
            law: The law.
            noise: Whether the encoders have noise.
        """
        scenario = self._prepared.scenario.model_copy(update={"controller": law, "noise": noise})
        shared = None if law.follows_link_motion else self._prepared.reference
        experiment = replace(self._prepared, scenario=scenario, given_reference=shared)
        law.check(experiment.loop_context)
        return experiment

    def measures_of_set(
        self, name: str, law: AbstractControlLaw, *, noise: bool = True, seeds: Sequence[int] = (1,)
    ) -> MotionMeasures:
        """Return the worst measures of a model set with a law, mean over the seeds."""
        experiment = self.experiment(law, noise=noise)
        values = self.problem.values(name, self._seed)
        count = len(next(iter(values.values())))
        wanted, step, problem = self.path, experiment.sample_time, self.problem

        def figure(record: RunRecord) -> MotionMeasures:
            if record.diverged >= 0:
                return lost_run(problem)
            error = 1e3 * (record.tool_pose[:, :3] - wanted)
            return measures_of_motion(problem, name, error, record.command, step)

        all_values = {key: np.tile(given, len(seeds)) for key, given in values.items()}
        all_seeds = [seed for seed in seeds for _ in range(count)]
        runs = batch(experiment, figure, values=all_values, seeds=all_seeds, threads=self._threads)
        return mean_motion([worst_motion(runs[count * place : count * (place + 1)]) for place in range(len(seeds))])

    @cached_property
    def path(self) -> FloatArray:
        """Path of the tool of the nominal model without disturbances and noise [m], shape (n, 3).

        The feedforward is exact, so it does not depend on the controller. On a robot whose gear angles are the output,
        as six_axis, it contains what the arm bends beyond them.
        """
        law = load_motion_controller(self.problem, "pid").nominal
        quiet = self.experiment(law, noise=False)
        quiet = replace(quiet, scenario=quiet.scenario.model_copy(update={"disturbances": ()}))
        run = batch(quiet, whole_record, seeds=[1], threads=1)[0]
        return run.tool_pose[:, :3]

    def _demands(self, controller: BenchmarkController, measures: dict[str, MotionMeasures]) -> tuple[Demand, ...]:
        found: list[Demand] = []
        for name, one in measures.items():
            found.append(Demand.below(f"settling, {name}", float(np.max(one.settling)), SETTLED, "s"))
            found.append(Demand.below(f"noise torque, {name}", one.noise_torque, NOISE_SHARE, "%"))
            found.append(Demand.below(f"largest torque, {name}", one.largest_torque, TORQUE_SHARE, "%"))
        for which, law in (("C1", controller.nominal), ("C2", controller.perturbed)):
            found += self.stability(law, which, (NOMINAL,) if which == "C1" else tuple(RULES))
        return tuple(found)

    def stability(self, law: AbstractControlLaw, which: str = "", sets: Sequence[str] = tuple(RULES)) -> list[Demand]:
        """Return the demands on the linear loops: largest eigenvalues about rest, with sampling and delay.

        Args:
            law: The law.
            which: C1 or C2, for the names.
            sets: Model sets that it regulates.
        """
        linear = linear_controller(law, law.context(self.problem.robot, self._prepared.sample_time))
        end = f", {which}" if which else ""
        found = [_stable(f"stability, {name}{end}", self._plants[name], linear) for name in sets]
        nominal = self._plants[NOMINAL]
        found.append(_stable(f"stability, loop gain x {LOOP_GAIN:g}{end}", nominal, linear, LOOP_GAIN))
        late = self._plants["late"]
        return [*found, _stable(f"stability, delay {1e3 * LONG_DELAY:g} ms{end}", late, linear)]

    def nominal_run(self, controller: BenchmarkController, seed: int = 1) -> MotionRun:
        """Run the nominal model with all disturbances and noise."""
        run = batch(self.experiment(controller.nominal), whole_record, seeds=[seed], threads=1)[0]
        count = len(run.tool_pose)
        return MotionRun(
            np.arange(count, dtype=np.float64) * self.sample_time,
            1e3 * np.linalg.norm(run.tool_pose[:, :3] - self.path[:count], axis=1),
            np.asarray(np.max(np.abs(highest(self.problem, run.command)), axis=1)),
        )

    @cached_property
    def _plants(self) -> dict[str, list[SampledPlants]]:
        """Sampled linear models of every set in every pose; of the nominal one with the long delay as well."""
        robot, step = self.problem.robot, self.sample_time
        plants: dict[str, list[SampledPlants]] = {"late": []}
        for name in RULES:
            values = self.problem.values(name, self._seed)
            table = np.array(list(values.values())).T
            models = [
                linear_plants(
                    robot,
                    names=tuple(values),
                    values=table,
                    pose=None if pose is None else np.array(pose),
                    label=name,
                )
                for pose in (self.problem.poses or (None,))
            ]
            plants[name] = [sampled_plants(model, step, robot.delay) for model in models]
            if name == NOMINAL:
                plants["late"] = [sampled_plants(model, step, LONG_DELAY) for model in models]
        return plants


def _stable(name: str, plants: list[SampledPlants], linear: Any, gain: float = 1.0) -> Demand:
    radii = [largest_eigenvalues(each, linear, gain) for each in plants]
    pose = int(np.argmax([np.max(each) for each in radii]))
    worst = int(np.argmax(radii[pose]))
    where = f"{plants[pose].labels[worst]}, pose {pose + 1}"
    return Demand.below(name, float(radii[pose][worst]), 1.0, "1", where)
