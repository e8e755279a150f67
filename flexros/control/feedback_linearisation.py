"""Feedback linearisation of the flexible-joint robot by static state feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.control.model.flexible_joints import FlexibleJointModel, GearMotion
from flexros.control.motorwise import Gain
from flexros.control.observed import AbstractObservedLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals
    from flexros.control.observers.base import Estimate


class FeedbackLinearisation(AbstractObservedLaw):
    """Static feedback linearisation (Spong 1987; Moberg 2007, equations 5.9 to 5.11).

        v = q_a,r'''' + L (x_r - x),  x = (q_a, q_a', q_a'', q_a''')
        u = M_m q_m'' + f(d) + D d' + f_m q_m',  q_m'' = q_a'' + (tau'' - f''(d) d'^2) / f'(d),  d = q_m - q_a

    with tau'' the second derivative of the load M_a q_a'' + n at q_a'''' = v. Acceleration and jerk of the links follow
    from positions and speeds of motors and links by the model, so that the links become chains of four integrators. L
    puts all four poles of each chain at -bandwidth (chosen), in every position. Exact for undamped gears; the damper D
    is compensated at the motor, but neglected between the links, as in the text. Gears may be nonlinear. The
    feedforward torque, which is part of the law, is not used.
    """

    kind: ClassVar[str] = "feedback_linearisation"
    gain_keys: ClassVar[tuple[str, ...]] = ("bandwidth",)

    bandwidth: Gain = Field(description="magnitude of the four poles of a link [rad/s], one or one per motor")

    def check(self, context: LoopContext) -> None:
        """Refuse a robot that is not of flexible joints, or that the observer does not fit."""
        FlexibleJointModel(context.robot)
        super().check(context)

    def command(self, estimate: Estimate, signals: LoopSignals, gains: Mapping[str, casadi.SX]) -> casadi.SX:
        """Return the command before its limit; see `AbstractObservedLaw.command`."""
        model, w, wanted = FlexibleJointModel(signals.context.robot), gains["bandwidth"], signals.reference
        links = model.measured_links(
            estimate.motor_position, estimate.motor_velocity, estimate.link_position, estimate.link_velocity
        )
        snap = (
            wanted("link_snap")
            + w**4 * (wanted("link_position") - links.position)
            + 4 * w**3 * (wanted("link_velocity") - links.velocity)
            + 6 * w**2 * (wanted("link_acceleration") - links.acceleration)
            + 4 * w * (wanted("link_jerk") - links.jerk)
        )
        return linearising_torque(model, estimate, snap)


def linearising_torque(model: FlexibleJointModel, estimate: Estimate, snap: casadi.SX) -> casadi.SX:
    """Return the motor torque that gives the links a fourth derivative, tau of equation 5.11 [Nm or N], SX (M, 1).

    Args:
        model: The flexible-joint model.
        estimate: Positions and speeds of motors and links.
        snap: Fourth derivative of the positions of the links [rad/s4 or m/s4], SX (N, 1).
    """
    links = model.measured_links(
        estimate.motor_position, estimate.motor_velocity, estimate.link_position, estimate.link_velocity
    )
    deflection = estimate.motor_position - estimate.link_position
    rate = estimate.motor_velocity - estimate.link_velocity
    gear = model.gear_motion(links, snap, GearMotion(deflection, rate, 0 * rate))
    held = model.spring_torque(deflection) + model.damping() * rate
    return model.motor_torque(held, estimate.motor_velocity, links.acceleration + gear.acceleration)
