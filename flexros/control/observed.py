"""Base of control laws on the states of motors and links, as an observer estimates them."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from pydantic import Field

from flexros.control.limited import AbstractSignalLaw
from flexros.control.observers.base import Observer
from flexros.control.observers.differences import Differences

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import casadi

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals
    from flexros.control.observers.base import Estimate


class AbstractObservedLaw(AbstractSignalLaw):
    """A law without states of its own on the estimate of an observer; it follows the motion of the links.

    How to add one: list the fields that are gains in `gain_keys` and write `command`.
    """

    observer: Observer = Field(
        default_factory=Differences,
        description="how positions [rad or m] and speeds of motors and links are found: kind differences, kalman, "
        "extended_kalman or accelerometer with its settings",
    )

    @abstractmethod
    def command(self, estimate: Estimate, signals: LoopSignals, gains: Mapping[str, casadi.SX]) -> casadi.SX:
        """Return the command before its limit [Nm or N], SX (M, 1)."""

    @property
    def follows_link_motion(self) -> bool:
        """Whether the references include the motion of the links."""
        return True

    def check(self, context: LoopContext) -> None:
        """Refuse a robot that the observer does not fit."""
        self.observer.check(context)

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states of the observer."""
        return self.observer.state_size(context)

    def further_gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return the gains of the observer."""
        return self.observer.gains(context)

    def control(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[casadi.SX, Callable[[casadi.SX], casadi.SX]]:
        """Compute one sample; see `AbstractSignalLaw.control`."""
        estimate, after = self.observer.estimate(state, signals, gains)
        return self.command(estimate, signals, gains), after
