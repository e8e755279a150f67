"""The contract of design methods, and their lookup by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.config.settings import Settings
from flexros.control.design.plants import LinearPlants, linear_plants, sampled_plants
from flexros.control.linear_controller import LinearController
from flexros.control.state_space import StateSpace
from flexros.discovery import members
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import casadi as ca

    from flexros.arrays import FloatArray
    from flexros.control.design.fixed_structure import DiscreteSystem
    from flexros.control.design.plants import SampledPlants
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class DesignProblem:
    """The robot for which a controller is designed, linearised over its spring range and at poses.

    Attributes:
        robot: The robot.
        sample_time: Sample time of the controller [s].
        delay: Delay of the command at the plant input [s].
        plants: Continuous models, springs from soft to stiff inside, poses outside.
        sampled: The same sampled, past commands as states.
        segments: Number of combinations of spring segments per pose.
        poses: Arm coordinates [rad or m], each of shape (N,).
        names: Parameters that differ between further plants.
        values: Their values (SI), shape (n_sets, n_parameters); None for those of the robot.
    """

    robot: Robot
    sample_time: float
    delay: float
    plants: LinearPlants
    sampled: SampledPlants
    segments: int
    poses: tuple[FloatArray, ...]
    names: tuple[str, ...] = ()
    values: FloatArray | None = None

    @classmethod
    def of(
        cls,
        robot: Robot,
        poses: Sequence[FloatArray] = (),
        *,
        sample_time: float | None = None,
        delay: float | None = None,
        names: Sequence[str] = (),
        values: FloatArray | None = None,
    ) -> DesignProblem:
        """Linearise a robot.

        Args:
            robot: The robot.
            poses: Arm coordinates [rad or m], each of shape (N,); default: home of the robot.
            sample_time: Sample time of the controller [s]; default: that of the robot.
            delay: Delay of the command [s]; default: that of the robot.
            names: Parameters that differ between further plants.
            values: Their values (SI), shape (n_sets, n_parameters); the first set is the nominal one.

        Raises:
            InputError: A pose does not fit the robot, or the robot is commanded by positions.
        """
        if robot.commands == "position":
            raise InputError(f"robot {robot.name} is commanded by positions; give one that is commanded by torques")
        time = robot.sample_time if sample_time is None else sample_time
        late = robot.delay if delay is None else delay
        chosen = tuple(np.asarray(pose, dtype=float) for pose in poses or [robot.home])
        plants = _plants(robot, chosen, tuple(names), values)
        segments = len(plants) // (len(chosen) * (1 if values is None else len(values)))
        sampled = sampled_plants(plants, time, late)
        return cls(robot, time, late, plants, sampled, segments, chosen, tuple(names), values)

    def sampled_with(self, further: ca.Function) -> SampledPlants:
        """Return the sampled plants with further measurements, see `linear_plants`."""
        plants = _plants(self.robot, self.poses, self.names, self.values, further)
        return sampled_plants(plants, self.sample_time, self.delay)

    def plant_at(self, stiffness_share: float) -> LinearPlants:
        """Return one model between the softest and the stiffest spring segment of the first pose.

        Args:
            stiffness_share: 0 for the softest, 1 for the stiffest segment; the model is affine in the stiffness.
        """
        soft, stiff = 0, self.segments - 1
        mixed = [
            (1.0 - stiffness_share) * matrix[soft] + stiffness_share * matrix[stiff]
            for matrix in (getattr(self.plants, name) for name in "ABCEF")
        ]
        return LinearPlants((f"{self.robot.name} share {stiffness_share:g}",), *(part[None] for part in mixed))

    def sampled_at(self, stiffness_share: float) -> SampledPlants:
        """Return the model of `plant_at` sampled, with its delay."""
        return sampled_plants(self.plant_at(stiffness_share), self.sample_time, self.delay)


def _plants(
    robot: Robot,
    poses: Sequence[FloatArray],
    names: tuple[str, ...],
    values: FloatArray | None,
    further: ca.Function | None = None,
) -> LinearPlants:
    """Return the continuous models of all poses, poses outside."""
    parts = [
        linear_plants(
            robot,
            names=names,
            values=values,
            pose=pose,
            label=f"{robot.name} pose {number + 1}" if len(poses) > 1 else robot.name,
            further=further,
        )
        for number, pose in enumerate(poses)
    ]
    return LinearPlants(
        tuple(label for part in parts for label in part.labels),
        *(np.concatenate([getattr(part, name) for part in parts]) for name in "ABCEF"),
    )


@dataclass(frozen=True, eq=False)
class Design:
    """A designed controller.

    Attributes:
        system: Controller from the errors of the motor positions to the torques.
        sample_time: Its sample time [s].
        anti_windup: Gain of the torque lost in the limit, shape (n, M); None for the default of the law.
        figures: What the method achieved, by name, e.g. its norm gamma.
    """

    system: DiscreteSystem
    sample_time: float
    anti_windup: FloatArray | None
    figures: Mapping[str, float]

    def law(self) -> StateSpace:
        """Return the control law."""
        return StateSpace.model_validate(
            {
                "A": self.system.A,
                "B": self.system.B,
                "C": self.system.C if self.system.order else [[] for _ in self.system.D],
                "D": self.system.D,
                "anti_windup": self.anti_windup,
                "matrices_sample_time": self.sample_time,
            }
        )

    def law_without_anti_windup(self) -> StateSpace:
        """Return the control law for a search: quicker to make, the same below its limit."""
        return replace(self, anti_windup=np.zeros((self.system.order, len(self.system.D)))).law()


class AbstractDesignMethod(Settings, ABC):
    """A method that designs a linear controller; its fields are the choices of the designer.

    How to add a method: write one file in `flexros/control/design/methods` with one final subclass. It provides:

    1. `method`, a class variable: the name by which the command line chooses it.
    2. Its choices as pydantic fields with description, unit and bounds.
    3. `tunable`: those of them that are positive numbers to be tuned.
    4. `design`: the controller for a problem, and what the method guarantees, as named figures.
    """

    method: ClassVar[str]
    tunable: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def design(self, problem: DesignProblem) -> Design:
        """Design a controller.

        Args:
            problem: The robot, linearised.

        Raises:
            InputError: The method has no solution with these choices.
        """


def as_linear(system: DiscreteSystem) -> LinearController:
    """Return a controller of the error as one of measured and reference positions."""
    return LinearController(
        from_state=system.C,
        from_reference=system.D,
        from_measured=-system.D,
        state_step=system.A,
        state_reference=system.B,
        state_measured=-system.B,
    )


@cache
def design_methods() -> Mapping[str, type[AbstractDesignMethod]]:
    """Return all design methods by name."""
    return members("flexros.control.design.methods", AbstractDesignMethod, "method")  # type: ignore[type-abstract]
