"""Trajectories that another node sends on joint_trajectory while the loop runs."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.logs.messages.joint_state import JointStateView
from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk
from flexros.logs.stamps import stamp_of
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from flexros_nodes.controller.node import READ_BUDGET, ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.protocol.reference.trajectory_request import RejectedTrajectoryError
from tests.nodes.loop_on_bench import Loop

pytestmark = pytest.mark.slow

NAMES = ("motor_1", "motor_2")
LAST = 1_200_000_000
Bench = Any  # the class is in conftest


class Sender:
    """A loop with a user node that publishes trajectories and receives the reference of the controller."""

    def __init__(self, bench: Bench, scenario: Path) -> None:
        self.loop = Loop(bench, scenario, FeedforwardNode, ControllerNode, begin_at_once=False)
        self.controller = self.loop.node(ControllerNode)
        self.references = self.loop.hear("joint_reference")
        self._publisher = self.loop.user.create_publisher(JointTrajectory, "joint_trajectory", 10)
        self.loop.bring_up()
        bench.spin_until(lambda: self._publisher.get_subscription_count() > 0)

    def step_to(self, sample: int) -> np.ndarray:
        """Step to a sample, and return its reference."""
        self.loop.bench.spin_until(lambda: self.loop.sample == 0)
        for _ in range(sample):
            self.loop.step()
        stamp = self.loop.plant.loop.stamp
        self.loop.bench.spin_until(lambda: self.controller.stamp == stamp)
        return self.controller.buffer.current.copy()

    def send(self, *points: tuple[float, list[float]], names: tuple[str, ...] = NAMES, sec: int = 0) -> None:
        message = JointTrajectory(joint_names=names)
        message.header.stamp.sec = sec
        for time, positions in points:
            point = JointTrajectoryPoint(positions=positions)
            seconds, nanoseconds = divmod(round(time * 1e9), 10**9)
            point.time_from_start.sec, point.time_from_start.nanosec = seconds, nanoseconds
            message.points.append(point)
        self._publisher.publish(message)

    def used(self) -> dict[int, np.ndarray]:
        """Finish the run, and return the position references by stamp [ns]."""
        self.loop.call("start")
        self.loop.finish()
        self.loop.bench.spin_until(lambda: stamp_of(self.references[-1]) == LAST)
        view = JointStateView(NAMES)
        return {sample.stamp_ns: np.array(sample.position) for sample in map(view.unpack, self.references)}


def test_trajectory_leads_from_the_present_reference_and_its_end_is_held(bench: Bench, short_scenario: Path) -> None:
    sender = Sender(bench, short_scenario)
    present = sender.step_to(20)[:2]
    now = sender.loop.plant.loop.stamp
    target = present + np.array([0.001, -0.002])
    sender.send((0.02, target[::-1].tolist()), names=("motor_2", "motor_1"))
    bench.spin_until(lambda: sender.controller.buffer.pending is not None)
    used = sender.used()
    assert used[now + 10_000_000] == pytest.approx(0.5 * (present + target), abs=1e-12)
    assert used[now + 20_000_000] == pytest.approx(target, abs=1e-12)
    assert used[LAST].tolist() == used[now + 25_000_000].tolist() == target.tolist()


def test_later_trajectory_replaces_the_one_before(bench: Bench, short_scenario: Path) -> None:
    sender = Sender(bench, short_scenario)
    present = sender.step_to(5)[:2]
    for step in (0.5, 0.001):
        sender.send((0.01, (present + step).tolist()))
    bench.spin_until(lambda: sender.controller.buffer.pending is not None)
    bench.spin_for(0.2)
    assert sender.used()[LAST] == pytest.approx(present + 0.001, abs=1e-12)


def test_in_a_flood_few_trajectories_are_read_and_the_newest_is_followed(
    bench: Bench, short_scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sender = Sender(bench, short_scenario)
    checked: list[Any] = []
    check = sender.controller.check_trajectory
    monkeypatch.setattr(sender.controller, "check_trajectory", lambda read: (checked.append(read), check(read)))
    present = sender.step_to(5)[:2]
    for i in range(READ_BUDGET + 7):
        sender.send((0.01, (present + 1e-4 * i).tolist()))
        bench.spin_for(0.02)
    assert len(checked) == READ_BUDGET
    used = sender.used()
    assert len(checked) == READ_BUDGET + 1
    assert used[LAST] == pytest.approx(present + 1e-4 * (READ_BUDGET + 6), abs=1e-12)


def test_invalid_trajectory_is_rejected_and_the_loop_continues(
    bench: Bench, short_scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sender = Sender(bench, short_scenario)
    said: list[str] = []
    logger = SimpleNamespace(warning=lambda text, **_: said.append(text))
    monkeypatch.setattr(sender.controller, "get_logger", lambda: logger)
    sender.step_to(5)
    sender.send((0.1, [0.0, 0.0]), names=("motor_1", "wrist"))
    sender.send((0.2, [0.0, 0.0]), (0.1, [0.0, 0.0]))
    sender.send((0.1, [0.0, float("nan")]))
    sender.send((0.1, [0.0, 2e3]))
    sender.send((0.1, [0.0]))
    sender.send((-0.1, [0.0, 0.0]))
    sender.send()
    sender.send((0.001, [0.0, 0.0]), sec=1)
    bench.spin_until(lambda: len(said) == 8)
    opening, closing = "a trajectory on joint_trajectory is rejected: ", "; the reference is unchanged"
    assert all(text.startswith(opening) and text.endswith(closing) for text in said)
    for text, sentence in zip(
        said,
        (
            "its joints are motor_1, wrist; allowed is each of motor_1, motor_2, once",
            "its times do not increase from 0 on",
            "points[0].positions of motor_2 is nan",
            "points[0].positions of motor_2 is 2000, allowed is up to 1000 either way (parameter position_limit)",
            "2 joint names but 1 values in points[0].positions",
            "its times do not increase from 0 on",
            "it has no points",
            "it ends at 1.0010 s of simulated time, in the past",
        ),
        strict=True,
    ):
        assert sentence in text
    used = sender.used()
    planned = Experiment.prepare(load_scenario(short_scenario)).reference.motor_position
    assert np.array_equal([used[stamp] for stamp in sorted(used)], planned)
    assert sender.controller.figures()["refused_trajectories"] == 8


@pytest.mark.parametrize(("law", "largest"), [("elbow_gravity_pd", 2e-4), ("elbow_computed_torque", 2e-3)])
def test_laws_of_the_rigid_model_carry_the_arm_along_points_without_torques(
    bench: Bench, tmp_path: Path, law: str, largest: float
) -> None:
    settings = {**load_scenario(law).settings(), "duration": 1.0}
    (tmp_path / "law.yaml").write_text(json.dumps(settings))
    sender = Sender(bench, tmp_path / "law.yaml")
    states = sender.loop.hear("joint_states")
    target = sender.step_to(1)[:2] + np.array([0.02, -0.03])
    sender.send((0.3, target.tolist()))
    bench.spin_until(lambda: sender.controller.buffer.pending is not None)
    sender.loop.call("start")
    sender.loop.finish()
    bench.spin_until(lambda: stamp_of(states[-1]) >= 1_990_000_000)
    reached = np.array(JointStateView(NAMES).unpack(states[-1]).position)
    assert np.abs(reached - target).max() < largest


def test_a_law_that_needs_higher_derivatives_refuses_points(bench: Bench) -> None:
    node = bench.add(ControllerNode, scenario="elbow_state_feedback")
    node.trigger_configure()
    with pytest.raises(RejectedTrajectoryError, match="computed_torque"):
        node.check_trajectory(JointTrajectoryChunk(0, NAMES, np.array([1_000_000_000]), positions=np.zeros((1, 2))))
