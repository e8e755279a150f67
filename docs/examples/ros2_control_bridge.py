"""Gives the commands of ros2_control the stamps of the loop: each measurement is answered with the newest command.

The hardware interface stamps a command with the time at which it was sent. The plant takes a command only with the
stamp of its measurement, so this node holds the newest one and sends it on with that stamp. Until the first: no torque.
"""

import contextlib
import signal

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState


class Bridge(Node):
    """Holds the newest command and answers measurements with it."""

    def __init__(self) -> None:
        super().__init__("ros2_control_bridge")
        self.newest: JointState | None = None
        self.reply = JointState()
        self.commands = self.create_publisher(JointState, "joint_commands", 100)
        self.create_subscription(JointState, "ros2_control_commands", self.hold, 1)
        self.create_subscription(JointState, "joint_states", self.answer, 200)

    def hold(self, command: JointState) -> None:
        """Take a command of the hardware interface."""
        self.newest = command

    def answer(self, state: JointState) -> None:
        """Answer a measurement; one that is repeated gets the same reply again."""
        if self.reply.header.stamp != state.header.stamp:
            command = self.newest or JointState(name=state.name, effort=[0.0] * len(state.name))
            self.reply = JointState(header=state.header, name=command.name, effort=command.effort)
        self.commands.publish(self.reply)


if __name__ == "__main__":
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # to be stopped is no error
    node = Bridge()
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            rclpy.spin_once(node, timeout_sec=0.2)  # a wait without bound would sleep through the signal
