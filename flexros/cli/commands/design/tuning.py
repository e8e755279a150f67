"""Controllers that are tuned on the feedback benchmark."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.cli.progress import progress_shown
from flexros.config.settings import validate
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.benchmark.tuning import Tunable
    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.methods.base import DesignProblem

STRUCTURE = "structure"
"""Method of a tuned structure, beside those of `flexros.control.design.methods`."""
STEP, SEED = 0.3, 1
"""First step of the search [1] and its seed, unless others are given."""


@dataclass(frozen=True)
class Tuning:
    """Search for a controller on the feedback benchmark.

    Attributes:
        laws: Laws tried per stage; 0 for no search.
        step: First step, in logarithms of the numbers [1].
        seed: Seed.
        start: Controller file from whose parameters it starts; None for none.
        only: The one controller that is tuned, "C1" or "C2"; empty for both.
    """

    laws: int
    step: float
    seed: int
    start: Path | None
    only: str

    @property
    def options(self) -> list[str]:
        """Its options of the command line, without those that are the default."""
        words = [f"--tune {self.laws}"] if self.laws else []
        words += [f"--step {self.step:g}"] if self.laws and self.step != STEP else []
        words += [f"--seed {self.seed}"] if self.laws and self.seed != SEED else []
        words += [f"--start {self.start}"] if self.start else []
        return words + ([f"--only {self.only}"] if self.only else [])

    def check(self, problem: DesignProblem) -> None:
        """Refuse a search that cannot be made.

        Raises:
            InputError: No laws to try, another robot than that of the benchmark, or one controller without the other.
        """
        from flexros.benchmark.models import ROBOT as BENCHMARK_ROBOT
        from flexros.benchmark.tuning import PARTS

        if self.laws < 1:
            raise InputError(
                f"{self.laws} laws per stage were given, but a structure is tuned; give at least one", "tune"
            )
        if problem.robot.name != BENCHMARK_ROBOT:
            raise InputError(
                f"robot {problem.robot.name} is not that of the benchmark, {BENCHMARK_ROBOT}; give that one", "model"
            )
        if self.only and (self.only not in PARTS or not self.start):
            raise InputError(
                f"'{self.only}' alone is to be tuned, allowed is C1 or C2, with a controller to start from; correct it",
                "only",
            )


@dataclass(frozen=True)
class _Stages:
    """Laws of rising order that are tuned one after the other.

    Attributes:
        each: The stages.
        first: Initial values by name.
        words: What is tuned, for the controller file.
    """

    each: Sequence[Tunable]
    first: dict[str, float]
    words: str


def tuned(
    method: str, settings: Mapping[str, float], problem: DesignProblem, tuning: Tuning, made_by: str
) -> tuple[dict[str, AbstractControlLaw], str]:
    """Tune both controllers of a design on the benchmark; return them with the text of the controller file.

    Args:
        method: Method of design.
        settings: Its choices by name.
        problem: Robot, poses and further plants.
        tuning: The search.
        made_by: Command that reproduces the design.

    Raises:
        InputError: The search cannot be made, or the choices do not suit the method.
    """
    from flexros.benchmark.evaluate import FeedbackBenchmark
    from flexros.benchmark.tuning import PARTS, controller_text, started_from
    from flexros.benchmark.tuning import tune as tuned_part

    tuning.check(problem)
    stages = _of_structure(settings, tuning) if method == STRUCTURE else _of_method(method, settings, problem)
    last, start = stages.each[-1], tuning.start
    known = {part: stages.first | (started_from(start, key) if start else {}) for part, key in PARTS.items()}
    bench = FeedbackBenchmark(last.sensors)
    found = {}
    with progress_shown() as show:
        for number, (part, key) in enumerate(PARTS.items()):
            if tuning.only and part != tuning.only:
                found[key] = known[part]
                continue
            found[key] = tuned_part(
                bench, stages.each, known[part], part, evaluations=tuning.laws, step=tuning.step, seed=tuning.seed,
                progress=lambda text, share, number=number: show(text, (number + share) / len(PARTS)),  # type: ignore[misc]
            ).values  # fmt: skip
    laws = {key: last.law(values, problem.sample_time) for key, values in found.items()}
    return laws, controller_text(stages.words, made_by, laws, found, last.sensors)


def _of_structure(settings: Mapping[str, float], tuning: Tuning) -> _Stages:
    """Return the stages of a PID with lead-lags and sections: from a start the last one alone."""
    from flexros.benchmark.tuning import structure_of, structure_stages

    structure = structure_of(settings)
    words = f"PID with {structure.text}, order {structure.order}, tuned on the cost V with the demands as constraints."
    return _Stages((structure,) if tuning.start else structure_stages(structure), structure.start(), words)


def _of_method(method: str, settings: Mapping[str, float], problem: DesignProblem) -> _Stages:
    """Return the weights of a method of design as the only stage."""
    from flexros.benchmark.tuning import TunableMethod
    from flexros.control.design.methods.base import design_methods

    chosen = validate(design_methods()[method], settings, f"method {method}")
    one = TunableMethod(chosen, problem)
    return _Stages((one,), one.start(), f"{first_line(type(chosen))} Its weights are tuned on the cost V.")


def first_line(method: type) -> str:
    """Return the first line of the docstring of a method.

    Args:
        method: Its class.
    """
    return (method.__doc__ or "").partition("\n")[0]
