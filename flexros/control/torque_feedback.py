"""Feedback of motor position and joint torque."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi
from pydantic import Field

from flexros.control.filtered_rate import FilteredRate
from flexros.control.limited import AbstractSignalLaw, Gain

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals


class TorqueFeedback(AbstractSignalLaw):
    """State feedback of motor position and joint torque (Albu-Schaeffer and Hirzinger 2000; Moberg 2007, 5.3.3).

        u = u_ffw + kp (q_m,r - q_m) + kd (q_m,r' - q_m') + kt (tau_r - tau) + ks (tau_r' - tau')

    tau are the joint torque sensors, tau_r = M_a q_a,r'' + c + g the torque that moves the links along their reference,
    with directions without motor rigid. The gain kt makes the motors appear 1 + kt times lighter. Rates are filtered
    differences of the deviations.
    """

    kind: ClassVar[str] = "torque_feedback"
    gain_keys: ClassVar[tuple[str, ...]] = ("kp", "kd", "kt", "ks", "speed_filter")

    kp: Gain = Field(description="gain of the motor position [Nm/rad], one or one per motor")
    kd: Gain = Field(default=0.0, description="gain of its rate [Nms/rad], one or one per motor")
    kt: Gain = Field(default=0.0, description="gain of the joint torque [1], one or one per motor")
    ks: Gain = Field(default=0.0, description="gain of its rate [s], one or one per motor")
    speed_filter: Gain = Field(
        default=0.0, description="time constant of the filter of the rates [s], 0 for none, one or one per motor"
    )

    @property
    def follows_link_motion(self) -> bool:
        """Whether the references include the motion of the links: the joint torques follow from it."""
        return True

    def check(self, context: LoopContext) -> None:
        """Refuse a robot without a torque sensor at every joint."""
        context.require("joint_torque")

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states, 4 M + 1."""
        return FilteredRate.size(2 * context.n_motors)

    def control(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[casadi.SX, Callable[[casadi.SX], casadi.SX]]:
        """Compute one sample; see `AbstractSignalLaw.control`."""
        context, robot, m = signals.context, signals.context.robot, signals.context.n_motors
        motion = [
            casadi.SX(robot.arm_from_gears(signals.reference(f"link_{name}")))
            for name in ("position", "velocity", "acceleration")
        ]
        carried = robot.model.arm_inverse_dynamics(*motion, robot.model.parameter_values)[list(robot.gear_rows)]
        position = signals.reference("motor_position") - signals.measured("motor_position")
        error = casadi.vertcat(position, carried - signals.measured("joint_torque"))
        rate = FilteredRate(state, error, casadi.repmat(gains["speed_filter"], 2, 1), context.sample_time)
        command = (
            signals.reference("feedforward_torque")
            + gains["kp"] * error[:m]
            + gains["kd"] * rate.rate[:m]
            + gains["kt"] * error[m:]
            + gains["ks"] * rate.rate[m:]
        )
        return command, lambda _: rate.after
