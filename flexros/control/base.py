"""The contract of feedback control laws, and their lookup by name."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexros.config.settings import Settings, validate
from flexros.control.context import LoopContext
from flexros.discovery import members
from flexros.errors import unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi

    from flexros.arrays import FloatArray
    from flexros.robot import Robot


class AbstractControlLaw(Settings, ABC):
    """A sampled feedback control law as a symbolic function; its fields are the keys of a scenario.

    How to add a controller: write one file in `flexros/control` with one final subclass. It is discovered by its
    `kind` in scenarios, in direct simulation, in batches and in the controller node. It provides:

    1. `kind`, a class variable: the name by which scenarios choose it.
    2. Its settings as pydantic fields with description, unit and bounds. Records are frozen, unknown keys refused.
    3. `state_size` and, unless it starts from zeros, `initial_state`: its state between samples.
    4. `gain_names` and `gains`: every parameter that may change at run time or be swept, as one vector.
    5. `function`: the pure update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function of state c (state_size,),
       references r (context.references.size,), measurements y (context.measurements.size,) and gains g (n_gains,),
       with the torque command u (M,). No clock, no randomness.

    6. `follows_link_motion`, true if its references include the motion of the links and its derivatives, and `check`,
       if it does not fit every robot.

    Each method gets a `LoopContext`: the nominal robot, the sample time and the layout of r and y by name, e.g.
    `context.references.part(r, "motor_velocity")`. An observer or state feedback designs its matrices from
    `linear_model(context.robot)`; a computed-torque law evaluates `context.robot.model`.

    A law that controls each motor separately, with gains per motor and a torque limit, derives from
    `flexros.control.motorwise.AbstractMotorwiseLaw` and provides only its gains and its update.
    """

    kind: ClassVar[str]
    lowest_gain: ClassVar[float] = -math.inf
    """Lower bound of all gains at run time."""
    links_as_motors: ClassVar[bool] = False
    """Whether a law that follows the links' motion may take it for the motors', up to the acceleration, where a
    trajectory of points tells no more."""

    @property
    def follows_link_motion(self) -> bool:
        """Whether the references include the motion of the links, `flexros.control.context.LINK_MOTION`."""
        return False

    def context(self, robot: Robot, sample_time: float) -> LoopContext:
        """Return the context of this law in a loop.

        Args:
            robot: The nominal robot.
            sample_time: Time between two samples [s].
        """
        return LoopContext(robot, sample_time, self.follows_link_motion)

    def check(self, context: LoopContext) -> None:
        """Refuse a robot that this law does not fit.

        Raises:
            InputError: Names law, robot and what is missing.
        """
        del context

    @abstractmethod
    def state_size(self, context: LoopContext) -> int:
        """Return the number of states."""

    @abstractmethod
    def gain_names(self, context: LoopContext) -> tuple[str, ...]:
        """Return the names of the entries of the gain vector, in order, e.g. "motor_1.kp"."""

    @abstractmethod
    def gains(self, context: LoopContext) -> FloatArray:
        """Return the gain vector in the order of `gain_names`, shape (n_gains,).

        Raises:
            InputError: A setting given per motor does not have one value for each.
        """

    @abstractmethod
    def function(self, context: LoopContext) -> casadi.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)`."""

    def command_limits(self, robot: Robot) -> FloatArray:
        """Return the largest torque command of the loop [Nm or N], shape (M,); infinite for no limit."""
        return robot.torque_limits

    def initial_state(self, context: LoopContext) -> FloatArray:
        """Return the state before the first sample, shape (state_size,)."""
        return np.zeros(self.state_size(context))


@cache
def control_laws() -> Mapping[str, type[AbstractControlLaw]]:
    """Return all control laws of this package, by `kind`."""
    return members("flexros.control", AbstractControlLaw, "kind")  # type: ignore[type-abstract]


def control_law(settings: Mapping[str, Any], source: str = "controller") -> AbstractControlLaw:
    """Build a control law from the mapping of a scenario.

    Args:
        settings: `kind` and the fields of that law, e.g. {"kind": "pid", "kp": 135000, "kd": 9000}.
        source: Origin of the settings; prefix of error messages.

    Raises:
        InputError: Unknown kind or invalid setting.
    """
    laws = control_laws()
    kind = str(settings.get("kind", ""))
    if kind not in laws:
        raise unknown_name("kind", kind, laws, source)
    return validate(laws[kind], {key: value for key, value in settings.items() if key != "kind"}, source)
