"""Effects that are laws of their own beside the robot's model: what all kinds of them have in common."""

from __future__ import annotations

from typing import ClassVar

from flexros.effects.kinds.base import AbstractEffect


class AbstractLaw(AbstractEffect):
    """An effect with a law of its own.

    Its parameters enter the plant as numbers or, where a batch varies or a diagnosis fits them, as symbols. A law may
    have states of its own, which stand behind [q, v] in the state of the plant: `smooth_states` with a derivative,
    then `stepwise_states` that are updated before or after each integration step and held through it. What its kind
    offers it (`MotorState`, `GearState`, ...) holds them as `own`.
    """

    size: ClassVar[str]
    """The parameter that switches the effect off when it is zero."""
    smooth_states: ClassVar[int] = 0
    """Number of own states with a derivative."""
    stepwise_states: ClassVar[int] = 0
    """Number of own states that are updated between the integration steps."""
    as_noise: ClassVar[bool] = False
    """Whether a predictor counts it as measurement noise of at most `noise`, and leaves it out of the plant."""

    @property
    def neutral(self) -> bool:
        """Whether the effect is switched off, so that it is left out of the plant."""
        return bool(getattr(self, self.size) == 0)

    @property
    def numbers(self) -> dict[str, float]:
        """Parameters of the law that are plain numbers, by name."""
        dumped = self.model_dump()
        return {
            name: float(dumped[name]) for name, field in type(self).model_fields.items() if field.annotation is float
        }

    @property
    def noise(self) -> float:
        """Largest error that it adds to a measured position as noise [rad or m]."""
        return 0.0

    @property
    def n_states(self) -> int:
        """Number of states of its own."""
        return self.smooth_states + self.stepwise_states

    def states_of_time(self, time: float) -> tuple[float, ...]:
        """Give own states that follow from the time alone.

        Args:
            time: Time since the begin of the run [s].

        Returns:
            The first own states; empty where none is of this kind.
        """
        del time
        return ()
