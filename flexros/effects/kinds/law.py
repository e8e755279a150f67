"""Effects that are laws in addition to the robot's model: their common base."""

from __future__ import annotations

from functools import cache
from typing import ClassVar

from flexros.effects.kinds.base import AbstractEffect


class AbstractLaw(AbstractEffect):
    """An effect with a law of its own.

    Its parameters enter the plant as numbers or, where a batch varies or a diagnosis fits them, as symbols. A law may
    have states of its own, appended to [q, v] in the state of the plant: `smooth_states` with a derivative, then
    `stepwise_states` that are updated before or after each integration step and held through it. The state that its
    kind passes to it (`MotorState`, `GearState`, ...) holds them as `own`.
    """

    size: ClassVar[str]
    """The parameter that switches the effect off when it and the `further_sizes` are zero."""
    further_sizes: ClassVar[tuple[str, ...]] = ()
    """Parameters that have an effect of their own where `size` is zero."""
    smooth_states: ClassVar[int] = 0
    """Number of own states with a derivative."""
    stepwise_states: ClassVar[int] = 0
    """Number of own states that are updated between the integration steps."""
    as_noise: ClassVar[bool] = False
    """Whether a predictor treats it as measurement noise of at most `noise`, and omits it from the plant."""

    @property
    def neutral(self) -> bool:
        """Whether the effect is switched off and omitted from the plant."""
        return not any(getattr(self, name) for name in (self.size, *self.further_sizes))

    @property
    def acting(self) -> AbstractLaw:
        """The law that acts in the plant: itself, or one of another kind that some of its values select."""
        return self

    @property
    def parameter_values(self) -> dict[str, float]:
        """Numerical parameters of the law, by name."""
        return {name: float(getattr(self, name)) for name in _numbers_of(type(self))}

    @property
    def noise(self) -> float:
        """Largest error that it adds to a measured position when it counts as noise [rad or m]."""
        return 0.0

    @property
    def n_states(self) -> int:
        """Number of own states."""
        return self.smooth_states + self.stepwise_states

    @property
    def n_driven_states(self) -> int:
        """Number of own states that the motion or the torques drive, which may be faster than the robot."""
        return self.n_states - len(self.states_of_time(0.0))

    @property
    def needs_short_steps(self) -> bool:
        """Whether it has states that may be faster than the robot, and that integration steps have to follow."""
        return self.n_driven_states > 0

    def states_of_time(self, time: float) -> tuple[float, ...]:
        """Return the leading own states that are functions of time alone; empty where there are none.

        Args:
            time: Time since the start of the run [s].
        """
        del time
        return ()


@cache
def _numbers_of(kind: type[AbstractLaw]) -> tuple[str, ...]:
    """Return the names of the numerical parameters of a law."""
    return tuple(name for name, field in kind.model_fields.items() if field.annotation is float)
