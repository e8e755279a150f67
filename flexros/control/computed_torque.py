"""Computed torque: linearisation of the rigid robot by feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.control.filtered_rate import FilteredRate
from flexros.control.limited import AbstractSignalLaw
from flexros.control.model.rigid_dynamics import rigid_torque
from flexros.control.motorwise import Gain

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import casadi

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals


class ComputedTorque(AbstractSignalLaw):
    """Computed torque control (Moberg 2007, equation 5.3): decoupled double integrators under a PD controller.

        v = q_d'' + kp (q_d - q) + kd (q_d' - q')
        u = M(q) v + c(q, q') + g(q)

    q are the motor positions, M, c and g those of the rigid robot with its motors: exact where gears and links are
    rigid, and an approximation well below the lowest resonance elsewhere. Each axis has the poles of
    s^2 + kd s + kp = 0, in every position. The feedforward torque, which is part of the law, is not used. The rate of
    the error is its filtered difference, the speed that of the reference less this rate.
    """

    kind: ClassVar[str] = "computed_torque"
    gain_keys: ClassVar[tuple[str, ...]] = ("kp", "kd", "speed_filter")
    links_as_motors: ClassVar[bool] = True

    kp: Gain = Field(description="acceleration per position error [1/s2], one or one per motor")
    kd: Gain = Field(description="acceleration per speed error [1/s], one or one per motor")
    speed_filter: Gain = Field(
        default=0.0, description="time constant of the speed filter [s], 0 for none, one or one per motor"
    )

    @property
    def follows_link_motion(self) -> bool:
        """Whether the references include the motion of the links: its acceleration is fed forward."""
        return True

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states, 2 M + 1."""
        return FilteredRate.size(context.n_motors)

    def control(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[casadi.SX, Callable[[casadi.SX], casadi.SX]]:
        """Compute one sample; see `AbstractSignalLaw.control`."""
        context, position = signals.context, signals.measured("motor_position")
        error = signals.reference("motor_position") - position
        rate = FilteredRate(state, error, gains["speed_filter"], context.sample_time)
        speed = signals.reference("motor_velocity") - rate.rate
        wanted = signals.reference("link_acceleration") + gains["kp"] * error + gains["kd"] * rate.rate
        return rigid_torque(context.robot, position, speed, wanted), lambda _: rate.after
