"""A controller that knows nothing of FlexROS: PID for each joint, over topics alone; it holds the start or swings."""

import contextlib
import math
import signal

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState


class ForeignController(Node):
    """Answers each measurement once, with a torque of the same stamp; asked again, it says the same again."""

    def __init__(self) -> None:
        super().__init__("foreign_controller")
        defaults = {"kp": [5600.0], "ki": [24000.0], "kd": [300.0], "swing": 0.0, "period": 1.0}  # Nm/rad, s; rad, s
        *self.gains, self.swing, self.period = (self.declare_parameter(*one).value for one in defaults.items())
        self.first = self.stamp = None
        self.commands = self.create_publisher(JointState, "joint_commands", 100)
        self.create_subscription(JointState, "joint_states", self.answer, 200)

    def answer(self, state: JointState) -> None:
        """Compute the torque of a measurement that is new, and publish it."""
        stamp = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
        if self.first is None:
            self.first, self.start, self.stamp = stamp, state.position, stamp - 1.0
            self.errors = self.sums = [0.0] * len(state.name)
        if stamp > self.stamp:
            step, self.stamp = stamp - self.stamp, stamp
            way = self.swing * math.sin(math.pi * (stamp - self.first) / self.period) ** 2
            errors = [start + way - q for start, q in zip(self.start, state.position)]
            rates = [(error - before) / step for error, before in zip(errors, self.errors)]
            self.errors, self.sums = errors, [total + error * step for total, error in zip(self.sums, errors)]
            p, i, d = (list(gain) * (len(errors) // len(gain)) for gain in self.gains)
            torque = [a * e + b * s + c * r for a, b, c, e, s, r in zip(p, i, d, errors, self.sums, rates)]
            self.reply = JointState(header=state.header, name=state.name, effort=torque)
        self.commands.publish(self.reply)


if __name__ == "__main__":
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # to be stopped is no error
    node = ForeignController()
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            rclpy.spin_once(node, timeout_sec=0.2)  # a wait without bound would sleep through the signal
