"""Tuning of structures and design methods on the benchmark, and the controller file that results."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from pydantic import ValidationError

from flexros.atomic_file import write_result
from flexros.benchmark.controllers import read_parameters
from flexros.benchmark.optimise import STABLE, UNSTABLE, optimise
from flexros.control.design.matrix_file import matrices_text
from flexros.control.design.tunable import TunableStructure
from flexros.control.state_space import StateSpace
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.benchmark.evaluate import FeedbackBenchmark
    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.methods.base import AbstractDesignMethod, DesignProblem

PARTS = {"C1": "nominal", "C2": "perturbed"}
"""The two controllers of a design, and their keys in a controller file."""
MOST_FACTORS = 6
"""Largest number of factors of a kind in a structure [1] (chosen)."""
LESS = 0.5
"""Factor on the step of the search from one stage to the next (chosen)."""


class Tunable(Protocol):
    """A controller as a function of named numbers."""

    @property
    def sensors(self) -> tuple[str, ...]:
        """Sensors beside the motor encoder."""
        ...

    def vector(self, values: dict[str, float]) -> FloatArray:
        """Return the point of the search of some values."""
        ...

    def values(self, vector: FloatArray) -> dict[str, float]:
        """Return the values at a point of the search."""
        ...

    def law(self, values: dict[str, float], sample_time: float, *, anti_windup: bool = True) -> AbstractControlLaw:
        """Return the law of some values."""
        ...


@dataclass(frozen=True)
class TunableMethod:
    """The weights of a design method as numbers to tune.

    Attributes:
        method: The method with its choices.
        problem: The robot.
    """

    method: AbstractDesignMethod
    problem: DesignProblem
    sensors: tuple[str, ...] = ()

    def start(self) -> dict[str, float]:
        """Return the choices of the method that are positive numbers."""
        return {name: float(getattr(self.method, name)) for name in self.method.tunable}

    def vector(self, values: dict[str, float]) -> FloatArray:
        """Return the logarithms, shape (n_parameters,)."""
        return np.log([values[name] for name in self.method.tunable])

    def values(self, vector: FloatArray) -> dict[str, float]:
        """Return the values at a point of the search."""
        return {name: float(np.exp(entry)) for name, entry in zip(self.method.tunable, vector, strict=True)}

    def law(self, values: dict[str, float], sample_time: float, *, anti_windup: bool = True) -> AbstractControlLaw:
        """Design the controller with some values.

        Raises:
            InputError: A value is out of its bounds, or there is no solution.
        """
        settings = {**self.method.model_dump(), **values}
        try:
            changed = type(self.method).model_validate(settings)
        except ValidationError as error:
            raise InputError(
                f"{self.method.method}: {values} are not allowed ({error.error_count()} errors)"
            ) from error
        design = changed.design(self.problem)
        return design.law() if anti_windup else design.law_without_anti_windup()


@dataclass(frozen=True, eq=False)
class Tuned:
    """Result of tuning one controller of a design.

    Attributes:
        values: Values of the numbers.
        cost: Share of V over the seeds of the search.
    """

    values: dict[str, float]
    cost: float


def structure_stages(structure: TunableStructure) -> tuple[TunableStructure, ...]:
    """Return structures from the plain PID to the wanted one, each with one factor more."""
    stages = [TunableStructure()]
    if structure.acceleration:
        stages.append(TunableStructure(acceleration=True))
    for number in range(1, structure.lead_lags + 1):
        stages.append(TunableStructure(0, number, structure.acceleration))
    for number in range(1, structure.sections + 1):
        stages.append(TunableStructure(number, structure.lead_lags, structure.acceleration))
    for number in range(1, structure.acceleration_sections + 1):
        stages.append(TunableStructure(structure.sections, structure.lead_lags, True, number))
    return tuple(stages)


def tune(
    benchmark: FeedbackBenchmark,
    stages: Sequence[Tunable],
    start: dict[str, float],
    part: str,
    *,
    evaluations: int,
    step: float = 0.3,
    seed: int = 1,
    seeds: Sequence[int] = (1,),
    progress: Callable[[str, float], None] | None = None,
) -> Tuned:
    """Tune a controller through stages of rising richness, each from the best of the one before.

    Args:
        benchmark: The benchmark, with the sensors of the last stage.
        stages: Structures; the values of one are known to the next.
        start: First values of the first stage.
        part: "C1" or "C2".
        evaluations: Number of laws to try in each stage.
        step: First standard deviation of the search in logarithms [1]; halved from stage to stage, not below 0.1.
        seed: Seed of the search.
        seeds: Seeds of the noise in the search.
        progress: Called with a text and the share that is done.

    Raises:
        InputError: No stable controller was found.
    """
    sample_time = benchmark.robot.sample_time
    known, cost = start, float("inf")
    for number, stage in enumerate(stages):
        if isinstance(stage, TunableStructure):
            known = stage.start(known)

        def law(point: FloatArray, stage: Tunable = stage) -> AbstractControlLaw:
            return stage.law(stage.values(point), sample_time, anti_windup=False)

        def tell(done: int, best: float, number: int = number) -> None:
            if progress is not None:
                share = (number + done / evaluations) / len(stages)
                progress(f"{part}, stage {number + 1} of {len(stages)}, cost {best:.2f}", share)

        found = optimise(
            benchmark, law, stage.vector(known), part, evaluations=evaluations, step=max(step * LESS**number, 0.1),
            seed=seed + number, seeds=seeds, progress=tell,
        )  # fmt: skip
        known, cost = stage.values(found.point), found.cost
    if cost >= UNSTABLE:
        raise InputError(
            f"no controller of {evaluations} tried has all eigenvalues below {STABLE}; give better first values or "
            "more evaluations",
            "tune",
        )
    return Tuned(known, cost)


def controller_text(
    description: str,
    made_by: str,
    laws: Mapping[str, AbstractControlLaw],
    parameters: Mapping[str, Mapping[str, float]] | None = None,
    sensors: Sequence[str] = (),
) -> str:
    """Return the YAML text of a controller file.

    Args:
        description: What the design is.
        made_by: Command that reproduces it.
        laws: Law by key: controller, or nominal and perturbed.
        parameters: Numbers from which the laws were made, by the same keys.
        sensors: Sensors beside the motor encoder.
    """
    lines = [f"description: >-\n  {description}", f"made_by: {made_by}"]
    if sensors:
        lines.append(f"sensors: [{', '.join(sensors)}]")
    text = "\n".join(lines) + "\n"
    for key, values in (parameters or {}).items():
        text += ("parameters:\n" if key == next(iter(parameters or {})) else "") + f"  {key}:\n"
        text += "".join(f"    {name}: {float(f'{value:.10g}')!r}\n" for name, value in values.items())
    for key, law in laws.items():
        text += f"{key}:\n" + _law_text(law)
    return text


def write_controller(file: Path, text: str) -> None:
    """Write a controller file.

    Raises:
        InputError: It cannot be written.
    """
    write_result(file, text, "controller file")


def _law_text(law: AbstractControlLaw) -> str:
    content: dict[str, Any] = {"kind": law.kind}
    for name, value in law.model_dump(mode="json", exclude_unset=True, exclude_defaults=True).items():
        matrix = isinstance(law, StateSpace) and name in ("A", "B", "C", "D", "anti_windup")
        content[name] = np.atleast_2d(np.array(value, dtype=float)) if matrix and value else value
    if isinstance(content.get("inputs"), list):
        content["inputs"] = f"[{', '.join(content['inputs'])}]"
    return matrices_text(content, "  ")


def structure_of(settings: Mapping[str, float]) -> TunableStructure:
    """Return the structure of choices by name.

    Raises:
        InputError: Unknown choice, or not a whole number from 0 to 6.
    """
    allowed = [field.name for field in fields(TunableStructure)]
    for name, value in settings.items():
        if name not in allowed:
            raise unknown_name("choice", name, allowed, "structure")
        if not (value == int(value) and 0 <= value <= MOST_FACTORS):
            raise InputError(f"{name} is {value:g}, allowed are whole numbers from 0 to {MOST_FACTORS}", "choice")
    numbers = {name: int(value) for name, value in settings.items()}
    acceleration = bool(numbers.pop("acceleration", 0))
    if numbers.get("acceleration_sections") and not acceleration:
        raise InputError("acceleration_sections is given without acceleration=1; add it", "choice")
    return TunableStructure(acceleration=acceleration, **numbers)


def started_from(file: Path, key: str) -> dict[str, float]:
    """Return the parameters of a controller file.

    Args:
        file: Controller file or built-in name.
        key: "nominal" or "perturbed".

    Raises:
        InputError: The file has no parameters.
    """
    values = read_parameters(file).get(key)
    if not values:
        raise InputError(f"'{file}' has no parameters of the key {key}, from which a search could start", "start")
    return values
