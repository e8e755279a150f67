"""The motion of the links in a reference chunk and back."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk
from flexros.logs.stamps import START_NS
from flexros_nodes.protocol.reference.link_columns import links_of, names_with_links, with_links
from flexros_nodes.protocol.reference.reference_buffer import ReferenceBuffer
from flexros_nodes.protocol.reference.trajectory_request import RejectedTrajectoryError

NAMES = ("motor_1", "motor_2")
MOTOR = np.arange(6.0).reshape(3, 2)
LINKS = np.arange(30.0).reshape(3, 5, 2) + 100.0


def chunk() -> JointTrajectoryChunk:
    names = names_with_links(NAMES)
    return JointTrajectoryChunk(
        START_NS,
        names,
        np.array([0, 1_000_000, 2_000_000]),
        positions=with_links(MOTOR, LINKS, 0),
        velocities=with_links(MOTOR + 50.0, LINKS, 1),
        effort=np.pad(MOTOR + 70.0, ((0, 0), (0, len(names) - 2))),
    )


def test_velocities_are_the_next_derivative_of_positions() -> None:
    names, sent = names_with_links(NAMES), chunk()
    assert names[2:] == (
        "motor_1.link", "motor_2.link", "motor_1.link_acceleration", "motor_2.link_acceleration",
        "motor_1.link_snap", "motor_2.link_snap",
    )  # fmt: skip
    assert sent.positions is not None
    assert sent.velocities is not None
    assert np.array_equal(sent.positions[:, 2:4], LINKS[:, 0])
    assert np.array_equal(sent.velocities[:, 2:4], LINKS[:, 1])
    assert np.array_equal(sent.velocities[:, 6:], np.zeros((3, 2)))


def test_links_come_back() -> None:
    sent = chunk()
    assert np.array_equal(links_of(sent.positions, sent.velocities, 2), LINKS.reshape(3, 10))  # type: ignore[arg-type]


def test_the_buffer_hands_out_the_row_of_the_controller() -> None:
    buffer = ReferenceBuffer(2, 1e-3, link_motion=True)
    buffer.append(chunk())
    row = buffer.take(START_NS + 1_000_000)
    assert row is not None
    assert np.array_equal(row, [*MOTOR[1], *(MOTOR[1] + 50.0), *(MOTOR[1] + 70.0), *LINKS[1].ravel()])


def test_trajectories_without_links_are_refused() -> None:
    buffer = ReferenceBuffer(2, 1e-3, link_motion=True)
    plain = JointTrajectoryChunk(0, NAMES, np.array([1_000_000_000]), positions=np.zeros((1, 2)))
    with pytest.raises(RejectedTrajectoryError, match="motion of the links"):
        buffer.check(plain, np.inf)
    with pytest.raises(RejectedTrajectoryError, match="pid"):
        buffer.replace(plain)


def test_trajectories_are_followed_by_a_law_whose_links_may_move_as_the_motors() -> None:
    buffer = ReferenceBuffer(2, 1e-3, link_motion=True, links_as_motors=True)
    buffer.append(chunk())
    buffer.take(START_NS)
    target = np.array([[7.0, -7.0]])
    buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([2_000_000]), positions=target))
    halfway = buffer.take(START_NS + 1_000_000)
    assert halfway is not None
    between, speed = 0.5 * (MOTOR[0] + target[0]), (target[0] - MOTOR[0]) / 2e-3
    assert halfway[:4] == pytest.approx([*between, *speed])
    assert halfway[6:] == pytest.approx([*between, *speed, *[0.0] * 6])
    buffer.come_to_rest(2e-3)
    slowing = buffer.take(START_NS + 2_000_000)
    assert slowing is not None
    assert slowing[10:12] == pytest.approx(-speed / 2e-3)
