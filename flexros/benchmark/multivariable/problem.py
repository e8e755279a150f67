"""Problems of the multivariable benchmark: robot, moving reference, disturbances, windows and model sets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexros.benchmark.models import NOMINAL, RULES
from flexros.errors import unknown_name
from flexros.random_streams import Stream, generator
from flexros.robot import load_robot
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.scenario.scenario import Scenario

_FOLDER = Path(__file__).parent / "problems"
MODELS = 10
"""Number of random models in each of the sets M1 and M2."""
SEED = 2008
"""Seed of the random models (chosen); designs are tuned on others, see `SEED_OF_DESIGN`."""
SEED_OF_DESIGN = 1
"""Seed of the random models on which the built-in designs were tuned."""
REST = (1.0, 1.5)
"""Start and end of the window in which noise is judged [s]; before it the controller takes up the weight that the model
has wrong."""


@dataclass(frozen=True)
class Window:
    """A window of the run.

    Attributes:
        name: What happens in it.
        start: Start [s].
        end: End [s].
        settles: Whether the settling time counts.
    """

    name: str
    start: float
    end: float
    settles: bool = False


@dataclass(frozen=True)
class Problem:
    """A problem of the multivariable benchmark.

    Attributes:
        name: Name of the robot.
        windows: Windows of the run, in order.
        torque: Torque to which the figures of each motor are referred [Nm], length M (the limits, where there are any).
        poses: Arm coordinates in which stability is checked [rad]; empty for home alone.
        band: Band of the settling time by model set [mm] (chosen).
    """

    name: str
    windows: tuple[Window, ...]
    torque: tuple[float, ...]
    poses: tuple[tuple[float, ...], ...]
    band: dict[str, float]

    @cached_property
    def robot(self) -> Robot:
        """The nominal robot."""
        return load_robot(self.name)

    @cached_property
    def inertia(self) -> FloatArray:
        """Inertia of motor and arm of every axis at home, the other axes held [kgm2], shape (M,)."""
        robot = self.robot
        arm = np.diag(np.asarray(robot.model.arm_inertia(robot.home, []), dtype=float))
        motors = [robot.parameters[f"{name}.inertia"].value for name in robot.joint_names]
        return np.array(motors) + arm[list(robot.gear_rows)]

    @property
    def file(self) -> Path:
        """The scenario of the nominal model, with a controller to be replaced."""
        return _FOLDER / f"{self.name}.yaml"

    @cached_property
    def scenario(self) -> Scenario:
        """The run of the nominal model."""
        return load_scenario(self.file)

    def values(self, name: str, seed: int = SEED) -> dict[str, FloatArray]:
        """Return the parameters of the models of a set.

        Stiffness, inertia and losses of every direction, body and motor are uniform within the deviations of `RULES`,
        each independent. Mass and inertia of a body of a planar robot share one factor; tensors of spatial bodies stay.

        Args:
            name: Name of the set, a key of `RULES`.
            seed: Seed of the models.

        Returns:
            Value by parameter (SI), shape (1 or 10,) each.
        """
        count, rules = (1, RULES[NOMINAL]) if name == NOMINAL else (MODELS, RULES[name])
        random = generator(seed, Stream.EXCITATION, list(RULES).index(name))
        values: dict[str, FloatArray] = {}
        for names, share in self._groups(rules.stiffness, rules.inertia, rules.losses):
            factor = 1.0 + share * random.uniform(-1.0, 1.0, count)
            values |= {each: self.robot.parameters[each].value * factor for each in names}
        return values

    def _groups(self, stiffness: float, inertia: float, losses: float) -> list[tuple[tuple[str, ...], float]]:
        """Return the parameters that share one factor, each with its largest deviation."""
        nonzero = [name for name, parameter in self.robot.parameters.items() if parameter.value != 0.0]
        groups: list[tuple[tuple[str, ...], float]] = []
        for number in range(1, len(self.robot.spec.bodies) + 1):
            tensor = [name for name in nonzero if name.startswith(f"body_{number}.inertia")]
            own = (f"body_{number}.mass", *(tensor if len(tensor) == 1 else ()))
            groups.append((own, inertia))
        for name in nonzero:
            if name.startswith("motor_") and name.endswith(".inertia"):
                groups.append(((name,), inertia))
            elif name.endswith(".stiffness"):
                groups.append(((name,), stiffness))
            elif name.endswith((".damping", ".viscous_friction")):
                groups.append(((name,), losses))
        return groups


def _windows(moved: float, settled: float, end: float) -> tuple[Window, ...]:
    """Return the windows of a run.

    Args:
        moved: End of the motion [s].
        settled: End of the rest after it [s].
        end: End of the run [s].
    """
    chirp = 2.0
    return (
        Window("step of the force", 1.5, 3.0, settles=True),
        Window("step of the torque", 3.0, 4.5, settles=True),
        Window("motion", 4.5, moved),
        Window("after the motion", moved, settled, settles=True),
        Window("chirp of the force", settled, settled + chirp),
        Window("chirp of the torque", settled + chirp, settled + 2 * chirp),
        Window("pulse of the force", settled + 2 * chirp, end),
    )


PROBLEMS: dict[str, Problem] = {
    "e12": Problem(
        "e12",
        _windows(6.1, 7.6, 12.6),
        (3000.0, 3000.0),
        ((0.0, 0.3, 0.0), (0.0, 0.6, 0.0)),
        {NOMINAL: 0.2, "M1": 0.2, "M2": 0.5},
    ),
    "six_axis": Problem(
        "six_axis",
        _windows(6.73, 8.0, 13.2),
        (15000.0, 15000.0, 8000.0, 1500.0, 1200.0, 800.0),
        (),
        {NOMINAL: 0.2, "M1": 0.2, "M2": 0.5},
    ),
}
"""The problems by name of the robot; all numbers are chosen."""


def problem_named(name: str) -> Problem:
    """Return a problem.

    Args:
        name: Name of the robot.

    Raises:
        InputError: There is no such problem.
    """
    if name not in PROBLEMS:
        raise unknown_name("robot of the multivariable benchmark", name, PROBLEMS)
    return PROBLEMS[name]


def highest(problem: Problem, command: FloatArray) -> FloatArray:
    """Return torques over those of the problem [%], shape (n, M)."""
    return np.asarray(100.0 * command / np.array(problem.torque))
