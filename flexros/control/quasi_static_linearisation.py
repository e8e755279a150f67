"""Feedback linearisation of the flexible-joint robot by quasi-static state feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.control.model.flexible_joints import FlexibleJointModel, LinkStates
from flexros.control.motorwise import Gain
from flexros.control.observed import AbstractObservedLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals
    from flexros.control.observers.base import Estimate


class QuasiStaticLinearisation(AbstractObservedLaw):
    """Feedback linearisation with a new input at the accelerations of the links (Delaleau and Rudolph 1998; chosen).

        v = q_a,r'' + 2 w (q_a,r' - q_a') + w^2 (q_a,r - q_a),   v' and v'' by differentiating v with q_a'' = v
        q_m* = q_a + f^-1(M_a v + n),  its rate w_1 and acceleration w_2 by differentiation with q_a'' = v
        u = M_m (w_2 + c_1 (w_1 - q_m') + c_0 (q_m* - q_m)) + f(d) + D d' + f_m q_m',   d = q_m - q_a

    Acceleration and jerk of the links, which equation 5.11 of Moberg (2007) takes from measured states, are those of
    the wanted motion, so noise of the deflection does not pass through the stiffness and the inverse inertia. Where the
    motors are on q_m*, each link has two poles at -w. For one axis of stiffness K and inertia J the other two are the
    roots of s^2 + 2 W s + W^2 + K / J = 0, with c_1 = 2 (w + W), c_0 = W^2 + w (w + 4 W) and the bandwidth W of the
    motors. Undamped gears as for `feedback_linearisation`. The feedforward torque is not used.
    """

    kind: ClassVar[str] = "quasi_static_linearisation"
    gain_keys: ClassVar[tuple[str, ...]] = ("bandwidth", "motor_bandwidth")

    bandwidth: Gain = Field(description="magnitude w of the two poles of a link [rad/s], one or one per motor")
    motor_bandwidth: Gain = Field(description="bandwidth W of the motors [rad/s], one or one per motor")

    def check(self, context: LoopContext) -> None:
        """Refuse a robot that is not of flexible joints, or that the observer does not fit."""
        FlexibleJointModel(context.robot)
        super().check(context)

    def command(self, estimate: Estimate, signals: LoopSignals, gains: Mapping[str, casadi.SX]) -> casadi.SX:
        """Return the command before its limit; see `AbstractObservedLaw.command`."""
        model, wanted = FlexibleJointModel(signals.context.robot), signals.reference
        link, speed = estimate.link_position, estimate.link_velocity
        w, motor_w = gains["bandwidth"], gains["motor_bandwidth"]
        error, rate = wanted("link_position") - link, wanted("link_velocity") - speed
        v = wanted("link_acceleration") + 2 * w * rate + w**2 * error
        v_rate = wanted("link_jerk") + 2 * w * (wanted("link_acceleration") - v) + w**2 * rate
        v_second = (
            wanted("link_snap") + 2 * w * (wanted("link_jerk") - v_rate) + w**2 * (wanted("link_acceleration") - v)
        )
        gear = model.gear_motion(LinkStates(link, speed, v, v_rate), v_second)
        behind = link + gear.deflection - estimate.motor_position
        slower = speed + gear.rate - estimate.motor_velocity
        proportional = motor_w**2 + w * (w + 4 * motor_w)
        acceleration = v + gear.acceleration + 2 * (w + motor_w) * slower + proportional * behind
        held = model.spring_torque(estimate.motor_position - link)
        held += model.damping() * (estimate.motor_velocity - speed)
        return model.motor_torque(held, estimate.motor_velocity, acceleration)
