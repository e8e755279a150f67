"""States by differences of measured positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi
from pydantic import Field

from flexros.control.filtered_rate import FilteredRate
from flexros.control.observers.base import AbstractObserver, Estimate

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals


class Differences(AbstractObserver):
    """Positions of motors and links as their encoders measure them, speeds by filtered differences.

    With the deviation e = reference - measurement, v = reference speed - rate of e: half a sample and the time constant
    of the filter delay the deviation alone, not the motion.
    """

    kind: ClassVar[str] = "differences"

    speed_filter: float = Field(default=0.0, ge=0.0, description="time constant of the speed filter [s], 0 for none")

    def check(self, context: LoopContext) -> None:
        """Refuse a robot without an encoder at every link."""
        context.require("link_position")

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states, 4 M + 1."""
        return FilteredRate.size(2 * context.n_motors)

    def gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return the time constant of the filter."""
        del context
        return {"observer.speed_filter": self.speed_filter}

    def estimate(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[Estimate, Callable[[casadi.SX], casadi.SX]]:
        """Estimate the states at a sample; see `AbstractObserver.estimate`."""
        m = signals.context.n_motors
        measured = casadi.vertcat(signals.measured("motor_position"), signals.measured("link_position"))
        wanted = casadi.vertcat(signals.reference("motor_position"), signals.reference("link_position"))
        speed = casadi.vertcat(signals.reference("motor_velocity"), signals.reference("link_velocity"))
        error = FilteredRate(state, wanted - measured, gains["observer.speed_filter"], signals.context.sample_time)
        speed -= error.rate
        return Estimate(measured[:m], speed[:m], measured[m:], speed[m:]), lambda _: error.after
