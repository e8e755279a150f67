"""Feedforward with feedback of all states of motors and links."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.control.observed import AbstractObservedLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi

    from flexros.control.limited import LoopSignals
    from flexros.control.observers.base import Estimate


class StateFeedback(AbstractObservedLaw):
    """Feedforward-dominant control (Moberg 2007, equation 5.12) with the states of motors and links of each axis.

        u = u_ffw + k_m (q_m,r - q_m) + d_m (q_m,r' - q_m') + k_a (q_a,r - q_a) + d_a (q_a,r' - q_a')

    The feedback matrix is diagonal, one set of four gains per axis, as in Albu-Schaeffer and Hirzinger (2000). With a
    perfect model all torques of the motion are feedforward: choose the method `flexible_joint`, whose references of
    motors and links belong together.
    """

    kind: ClassVar[str] = "state_feedback"
    gain_keys: ClassVar[tuple[str, ...]] = ("motor_position", "motor_speed", "link_position", "link_speed")
    lowest_gain: ClassVar[float] = float("-inf")

    motor_position: float | tuple[float, ...] = Field(description="gain k_m [Nm/rad], one or one per motor")
    motor_speed: float | tuple[float, ...] = Field(description="gain d_m [Nms/rad], one or one per motor")
    link_position: float | tuple[float, ...] = Field(description="gain k_a [Nm/rad], one or one per motor")
    link_speed: float | tuple[float, ...] = Field(description="gain d_a [Nms/rad], one or one per motor")

    def command(self, estimate: Estimate, signals: LoopSignals, gains: Mapping[str, casadi.SX]) -> casadi.SX:
        """Return the command before its limit; see `AbstractObservedLaw.command`."""
        wanted = signals.reference
        return (
            wanted("feedforward_torque")
            + gains["motor_position"] * (wanted("motor_position") - estimate.motor_position)
            + gains["motor_speed"] * (wanted("motor_velocity") - estimate.motor_velocity)
            + gains["link_position"] * (wanted("link_position") - estimate.link_position)
            + gains["link_speed"] * (wanted("link_velocity") - estimate.link_velocity)
        )
