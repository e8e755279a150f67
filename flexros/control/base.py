"""What a feedback controller is, and how one is found by its name."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexros.config.settings import Settings, validate
from flexros.discovery import members
from flexros.errors import unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi

    from flexros.arrays import FloatArray


class AbstractControlLaw(Settings, ABC):
    """A sampled feedback control law, written once as a symbolic function; its fields are the keys of a scenario.

    How to add a controller: write one file in `flexros/control` with one final subclass, which is then found by its
    name in scenarios, in the direct simulation, in batches and in the controller node alike. It provides:

    1. `kind`, a class variable: the name by which scenarios choose it.
    2. Its settings as pydantic fields with description, unit and bounds. Records are frozen, unknown keys refused.
    3. `state_size` and, where it does not start from zeros, `initial_state`: its memory between samples.
    4. `gain_names` and `gains`: every number that may change while running or be swept, as one vector.
    5. `function`: the pure update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function with the shapes
       c (state_size,), r (3 M,) = [motor position, motor velocity, feedforward torque], y (M,) measured motor
       position, g (n_gains,), u (M,) torque command. No clock, no randomness: sample time is an argument.

    A law that treats each motor for itself, with gains per motor and a torque limit, derives from
    `flexros.control.motorwise.AbstractMotorwiseLaw`, which leaves only its gains and its update to write.
    """

    kind: ClassVar[str]
    lowest_gain: ClassVar[float] = -math.inf
    """Lowest value that a gain may be given while running."""

    @abstractmethod
    def state_size(self, n_motors: int) -> int:
        """Give the number of memory variables for `n_motors` motors."""

    @abstractmethod
    def gain_names(self, n_motors: int) -> tuple[str, ...]:
        """Name the entries of the gain vector, in order, e.g. "motor_1.kp"."""

    @abstractmethod
    def gains(self, n_motors: int, torque_limits: FloatArray | None = None) -> FloatArray:
        """Give the gain vector.

        Args:
            n_motors: Number of motors M.
            torque_limits: Limits of the robot's motors [Nm], shape (M,); none where not given.

        Returns:
            Gains in the order of `gain_names`, shape (n_gains,).

        Raises:
            InputError: A setting given per motor does not have one value for each.
        """

    @abstractmethod
    def function(self, n_motors: int, sample_time: float) -> casadi.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)`.

        Args:
            n_motors: Number of motors M.
            sample_time: Time between two samples [s].
        """

    def initial_state(self, n_motors: int) -> FloatArray:
        """Give the memory before the first sample, shape (state_size,)."""
        return np.zeros(self.state_size(n_motors))


@cache
def control_laws() -> Mapping[str, type[AbstractControlLaw]]:
    """Find all control laws in this package, by `kind`."""
    return members("flexros.control", AbstractControlLaw, "kind")  # type: ignore[type-abstract]


def control_law(settings: Mapping[str, Any], source: str = "controller") -> AbstractControlLaw:
    """Make a control law from the mapping of a scenario.

    Args:
        settings: `kind` and the fields of that law, e.g. {"kind": "pid", "kp": 135000, "kd": 9000}.
        source: Where the settings came from, opens the error text.

    Returns:
        The law.

    Raises:
        InputError: No such kind, or a setting is wrong.
    """
    laws = control_laws()
    kind = str(settings.get("kind", ""))
    if kind not in laws:
        raise unknown_name("kind", kind, laws, source)
    return validate(laws[kind], {key: value for key, value in settings.items() if key != "kind"}, source)
