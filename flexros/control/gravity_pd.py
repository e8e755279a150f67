"""PD controller of the motor positions with gravity compensation."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from flexros.control.filtered_rate import FilteredRate
from flexros.control.limited import AbstractSignalLaw
from flexros.control.model.rigid_dynamics import gravity_torque
from flexros.control.motorwise import Gain

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import casadi

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals


class GravityPd(AbstractSignalLaw):
    """PD on the motor positions plus the torque that holds the arm (Tomei 1991; Moberg 2007, section 5.3.2).

        u = kp e + kd e' + g(q),  e = q_m,r - q_m

    `at: reference` takes gravity at the desired position of the links, as Tomei proves stable for a reference at rest;
    `at: measured` at the measured motor position less the deflection of the reference, q_m - (q_m,r - q_a,r). At rest
    the motors reach their reference without integral action; the links reach theirs if the feedforward method adds the
    deflection of the gears, as `flexible_joint` does. The feedforward torque, which holds gravity already, is not used.
    The rate of the error is its filtered difference.
    """

    kind: ClassVar[str] = "gravity_pd"
    gain_keys: ClassVar[tuple[str, ...]] = ("kp", "kd", "speed_filter")
    links_as_motors: ClassVar[bool] = True

    kp: Gain = Field(description="proportional gain [Nm/rad], one or one per motor")
    kd: Gain = Field(default=0.0, description="derivative gain [Nms/rad], one or one per motor")
    speed_filter: Gain = Field(
        default=0.0, description="time constant of the filter of the rate [s], 0 for none, one or one per motor"
    )
    at: Literal["reference", "measured"] = Field(
        default="reference", description="where gravity is taken: desired or measured position of the links [rad or m]"
    )

    @property
    def follows_link_motion(self) -> bool:
        """Whether the references include the motion of the links: gravity acts there."""
        return True

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states, 2 M + 1."""
        return FilteredRate.size(context.n_motors)

    def control(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[casadi.SX, Callable[[casadi.SX], casadi.SX]]:
        """Compute one sample; see `AbstractSignalLaw.control`."""
        context, position = signals.context, signals.measured("motor_position")
        target, link = signals.reference("motor_position"), signals.reference("link_position")
        error = target - position
        rate = FilteredRate(state, error, gains["speed_filter"], context.sample_time)
        place = link if self.at == "reference" else position - (target - link)
        command = gains["kp"] * error + gains["kd"] * rate.rate
        return command + gravity_torque(context.robot, place), lambda _: rate.after
