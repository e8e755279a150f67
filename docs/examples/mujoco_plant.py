"""A plant that knows nothing of FlexROS: a MuJoCo model behind the topics of the loop, in lock-step.

Each actuator of the model drives the joint of a motor; the names of those joints are the names in the messages.
"""

import contextlib

import mujoco
import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

BEGIN, SECOND = 1_000_000_000, 1_000_000_000  # stamps count from 1 s, because a time of 0 means "not set" in ROS
RESEND, CLOCK = 0.1, 0.01  # s of the wall clock; s of simulated time
DEPTH = 2000  # a recorder must not miss a sample while it is held up


class MujocoPlant(Node):
    """Publishes the measurement of t_k, and moves on when the command with the same stamp is there."""

    def __init__(self) -> None:
        super().__init__("mujoco_plant")
        defaults = {"model": "two_mass.xml", "sample_time": 1e-3, "duration": 1.0, "listeners": 1, "watchers": 0}
        model, self.sample_time, duration, self.listeners, self.watchers = (
            self.declare_parameter(name, value).value for name, value in defaults.items()
        )
        self.model = mujoco.MjModel.from_xml_path(model)
        self.data = mujoco.MjData(self.model)
        self.steps = round(self.sample_time / self.model.opt.timestep)
        self.names = [self.model.joint(number).name for number in self.model.actuator_trnid[:, 0]]
        self.addresses = [self.model.joint(name).qposadr[0] for name in self.names]
        self.k, self.last, self.repeats = -1, round(duration / self.sample_time), 0
        self.done = rclpy.Future()
        self.states = self.create_publisher(JointState, "joint_states", DEPTH)
        self.poses = self.create_publisher(PoseStamped, "tool_pose", DEPTH)
        self.clock = self.create_publisher(Clock, "/clock", 10)
        self.create_subscription(JointState, "joint_commands", self.move, 10)
        self.create_timer(RESEND, self.look_around)

    def look_around(self) -> None:
        """Begin when all listeners are there; say again what no command has answered."""
        if self.k < 0:
            states, poses = (topic.get_subscription_count() for topic in (self.states, self.poses))
            if states >= self.listeners and poses >= self.watchers:  # each topic finds its subscribers for itself
                self.measure()
        elif self.k == self.seen:
            self.repeats += 1
            self.publish()
        self.seen = self.k

    def measure(self) -> None:
        """Fill the messages of the next sample and publish them."""
        self.k += 1
        time = BEGIN + round(self.k * self.sample_time * SECOND)
        mujoco.mj_forward(self.model, self.data)
        self.state = JointState(name=self.names, position=[self.data.qpos[at] for at in self.addresses])
        self.state.header.stamp.sec, self.state.header.stamp.nanosec = divmod(time, SECOND)
        self.pose = PoseStamped(header=self.state.header)
        self.pose.header.frame_id = "base"
        position, turn = self.data.site("tool").xpos, self.data.body("arm").xquat
        self.pose.pose.position.x, self.pose.pose.position.y, self.pose.pose.position.z = map(float, position)
        to = self.pose.pose.orientation
        to.w, to.x, to.y, to.z = map(float, turn)
        self.publish()

    def publish(self) -> None:
        """Publish the measurement, for the first time or again; now and then the clock, by which others follow."""
        self.states.publish(self.state)
        self.poses.publish(self.pose)
        if self.k % round(CLOCK / self.sample_time) == 0:
            self.clock.publish(Clock(clock=self.state.header.stamp))

    def move(self, command: JointState) -> None:
        """Move to the next sample by a command, if it answers the present measurement."""
        if self.k < 0 or command.header.stamp != self.state.header.stamp:
            return
        if self.k == self.last:
            if not self.done.done():
                self.done.set_result(None)
            return
        self.data.ctrl[:] = [command.effort[command.name.index(name)] for name in self.names]
        mujoco.mj_step(self.model, self.data, self.steps)
        self.measure()


if __name__ == "__main__":
    rclpy.init()
    plant = MujocoPlant()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin_until_future_complete(plant, plant.done)
        for publisher in (plant.states, plant.poses):
            publisher.wait_for_all_acked(Duration(seconds=5.0))
        print(f"{plant.k + 1} samples, {plant.repeats} sent again")
