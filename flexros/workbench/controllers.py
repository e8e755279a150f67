"""Design of controllers, and their evaluation on the feedback benchmark."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from flexros.benchmark.controllers import BenchmarkController, load_controller
from flexros.benchmark.evaluate import SEEDS, BenchmarkResult, FeedbackBenchmark, check_noise
from flexros.benchmark.simulation import NOISE
from flexros.config.settings import validate
from flexros.control.context import LoopContext
from flexros.control.design.margins import loop_margins
from flexros.control.design.methods.base import DesignProblem, design_methods
from flexros.control.linear_controller import linear_controller
from flexros.errors import InputError, unknown_name
from flexros.workbench.given import robot_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import control
    import pandas as pd
    import plotly.graph_objects as go
    from numpy.typing import ArrayLike

    from flexros.control.design.margins import LoopMargins
    from flexros.control.design.methods.base import AbstractDesignMethod, Design
    from flexros.control.linear_controller import LinearController
    from flexros.control.state_space import StateSpace
    from flexros.report.base import Block
    from flexros.workbench.given import GivenModel

PICTURES = ("bode", "nyquist", "step")
"""Pictures of the loops of a controller."""


@dataclass(frozen=True, eq=False, repr=False)
class ControllerDesign:
    """A designed controller with its loops.

    Attributes:
        method: The method with its choices.
        problem: The robot linearised over its spring range and poses.
        design: Matrices and figures of the method.
    """

    method: AbstractDesignMethod
    problem: DesignProblem
    design: Design

    @property
    def figures(self) -> dict[str, float]:
        """What the method guarantees, by name, e.g. its norm gamma."""
        return dict(self.design.figures)

    @cached_property
    def law(self) -> StateSpace:
        """The control law, as a scenario takes it under the key `controller`."""
        return self.design.law()

    @cached_property
    def linear(self) -> LinearController:
        """The controller about rest, away from its limits."""
        return linear_controller(self.law, LoopContext(self.problem.robot, self.problem.sample_time))

    @cached_property
    def margins(self) -> tuple[LoopMargins, ...]:
        """Margins of every plant and motor, the other loops closed."""
        return loop_margins(self.problem.sampled, self.linear)

    @property
    def stable(self) -> bool:
        """Whether the loop is stable with every plant."""
        return all(entry.largest_eigenvalue < 1.0 for entry in self.margins)

    def to_control(self) -> control.StateSpace:
        """Return the sampled controller from errors of the motor positions to motor torques, for python-control."""
        import control as pc

        system, names = self.design.system, list(self.problem.robot.joint_names)
        return pc.ss(system.A, system.B, system.C, system.D, self.design.sample_time, inputs=names, outputs=names)

    def to_pandas(self) -> pd.DataFrame:
        """Return the margins by plant and motor: gain, phase [deg], delay [s], sensitivity, overshoot, settling [s]."""
        import pandas as pd

        return pd.DataFrame([entry.as_dict() for entry in self.margins]).set_index(["plant", "motor"])

    def plot(self, what: str = "bode", *, motor: int = 0) -> go.Figure:
        """Draw the loop at a motor with every plant, the other loops closed.

        Args:
            what: "bode" (loop gain and sensitivities), "nyquist", or "step" of the reference.
            motor: Number of the motor, from 0.

        Raises:
            InputError: Another word, or there is no such motor.
        """
        from flexros.analysis.report.loop import loop_pictures

        if what not in PICTURES:
            raise unknown_name("picture", what, PICTURES)
        motors = self.problem.robot.n_motors
        if not 0 <= motor < motors:
            raise InputError(f"the motor is {motor}, allowed are 0 to {motors - 1}; correct it", "motor")
        pictures = loop_pictures(self.problem.sampled, self.linear, motor)
        return pictures[PICTURES.index(what)].figure

    def write(self, file: str | Path) -> Path:
        """Write the controller file, which `flexros benchmark` and scenarios take.

        Raises:
            InputError: The file exists or cannot be written.
        """
        from flexros.benchmark.tuning import controller_text, write_controller

        path = Path(file)
        text = (type(self.method).__doc__ or self.method.method).splitlines()[0]
        write_controller(path, controller_text(text, self._made_by(), {"controller": self.law}))
        return path

    def _made_by(self) -> str:
        choices = self.method.model_dump(exclude_unset=True)
        words = [repr(self.method.method), repr(self.problem.robot.source), *(f"{k}={v!r}" for k, v in choices.items())]
        return f"flexros.design({', '.join(words)})"

    def __repr__(self) -> str:
        state = "stable" if self.stable else "unstable"
        order, plants = self.design.system.order, len(self.problem.sampled.labels)
        return f"<ControllerDesign {self.method.method}: order {order}, {state} with {plants} plants>"

    def _repr_html_(self) -> str:
        from flexros.analysis.report.loop import loop_table
        from flexros.report.base import Paragraph
        from flexros.report.notebook import notebook_html

        text = "; ".join(f"{name} {value:.4g}" for name, value in self.figures.items())
        blocks: list[Block] = [
            Paragraph(f"Order {self.design.system.order}{f'; {text}' if text else ''}."),
            *loop_table(self.margins),
        ]
        return notebook_html(f"{self.method.method} for {self.problem.robot.name}", blocks)


def design(method: str, model: GivenModel, *, poses: Sequence[ArrayLike] = (), **choices: float) -> ControllerDesign:
    """Design a linear controller for a robot over its spring range and poses.

    Args:
        method: "lqg", "pole_placement", "loop_shaping", "mixed_sensitivity", "mu_synthesis", "qft", ..., see
            `flexros design`.
        model: The robot: built-in name, path of a robot file or of a patch, or a robot.
        poses: Arm coordinates [rad or m], each of shape (N,); default: home of the robot.
        **choices: Choices of the method, each with its unit, see `flexros design`; default: those of the method.

    Returns:
        The controller; `margins` of its loops, `to_control()`, `plot()`, and `write` for its file.

    Raises:
        InputError: Unknown method or choice, or the method has no solution with these choices.
    """
    methods = design_methods()
    if method not in methods:
        raise unknown_name("method", method, methods)
    problem = DesignProblem.of(robot_of(model), [np.asarray(pose, dtype=float) for pose in poses])
    chosen = validate(methods[method], dict(choices), f"method {method}")
    return ControllerDesign(chosen, problem, chosen.design(problem))


class BenchmarkResults(Sequence[BenchmarkResult]):
    """Results of controllers on the feedback benchmark, side by side.

    Args:
        results: The results, at least one.
    """

    def __init__(self, results: Sequence[BenchmarkResult]) -> None:
        self._results = tuple(results)

    @overload
    def __getitem__(self, index: int) -> BenchmarkResult: ...

    @overload
    def __getitem__(self, index: slice) -> BenchmarkResults: ...

    def __getitem__(self, index: int | slice) -> BenchmarkResult | BenchmarkResults:
        return BenchmarkResults(self._results[index]) if isinstance(index, slice) else self._results[index]

    def __len__(self) -> int:
        return len(self._results)

    def __iter__(self) -> Iterator[BenchmarkResult]:
        return iter(self._results)

    def as_dict(self) -> list[dict[str, Any]]:
        """Return the results for JSON."""
        return [result.as_dict() for result in self]

    def to_pandas(self) -> pd.DataFrame:
        """Return cost V, its parts and the worst measures of each model set, a column per controller."""
        from flexros.benchmark.shown import measures_frame

        return measures_frame(self._results)

    def plot(self) -> go.Figure:
        """Draw the weighted costs of the model sets as stacked bars, one per controller; their sum is V."""
        from flexros.benchmark.shown import costs_figure

        return costs_figure(self._results)

    def __repr__(self) -> str:
        return f"<BenchmarkResults: {', '.join(f'{one.name} V = {one.cost:.5g}' for one in self)}>"

    def _repr_html_(self) -> str:
        from flexros.benchmark.shown import results_html

        return results_html(self._results)


def benchmark_controllers(
    *controllers: BenchmarkController | ControllerDesign | str | Path,
    noise: float = NOISE,
    seeds: Sequence[int] = SEEDS,
    progress: Callable[[str], None] | None = None,
) -> BenchmarkResults:
    """Evaluate controllers on the feedback benchmark of Moberg (2007), Paper C: cost V, measures, demands of 21 models.

    Args:
        *controllers: Built-in names, paths of controller files (YAML or Python), or designs for `four_mass`.
        noise: Standard deviation of the measurement noise [rad]; 0 for none.
        seeds: Seeds of the noise, over which the measures are averaged.
        progress: Called with the name of each step.

    Returns:
        A result for each controller: smaller V is better, `passed` tells whether all demands are met.

    Raises:
        InputError: No controller, an unknown one, or one that does not fit the robot of the benchmark.
    """
    if not controllers:
        raise InputError("no controller was given; give names of built-in ones, or paths of files", "controller")
    check_noise(noise, tuple(seeds))
    loaded = [_controller(one) for one in controllers]
    names = [one.name for one in loaded]
    if len(set(names)) < len(names):
        raise InputError(
            f"controllers {', '.join(names)} do not all have names of their own; write a design to a file of its own",
            "controller",
        )
    benches = {one.sensors: FeedbackBenchmark(one.sensors) for one in loaded}
    results = []
    for one in loaded:
        tell = None if progress is None else partial(_of_controller, progress, one.name)
        results.append(benches[one.sensors].evaluate(one, noise=noise, seeds=seeds, progress=tell))
    return BenchmarkResults(results)


def _of_controller(progress: Callable[[str], None], name: str, step: str) -> None:
    progress(f"{name}: {step}")


def _controller(given: BenchmarkController | ControllerDesign | str | Path) -> BenchmarkController:
    if isinstance(given, BenchmarkController):
        return given
    if isinstance(given, ControllerDesign):
        return BenchmarkController(f"{given.method.method}, designed", given.law, given.law)
    return load_controller(given)
