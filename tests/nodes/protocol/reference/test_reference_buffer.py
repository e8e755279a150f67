"""The reference that a controller holds."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.errors import RunError
from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk
from flexros.logs.stamps import stamp_ns, stamps_ns
from flexros_nodes.protocol.reference import reference_buffer, trajectory_request
from flexros_nodes.protocol.reference.reference_buffer import ReferenceBuffer

T = 5e-4
NAMES = ("motor_1", "motor_2")
RNG = np.random.default_rng(4)


def chunk(first: int, n: int, values: FloatArray) -> JointTrajectoryChunk:
    """Samples first ... first + n - 1 of values (n_all, 6)."""
    stamps = stamps_ns(first + n, T)[first:]
    rows = values[first : first + n]
    return JointTrajectoryChunk(int(stamps[0]), NAMES, stamps - stamps[0], rows[:, :2], rows[:, 2:4], None, rows[:, 4:])


@pytest.fixture
def values() -> FloatArray:
    return RNG.standard_normal((60, 6))


@pytest.fixture
def buffer() -> ReferenceBuffer:
    return ReferenceBuffer(2, T)


def test_chunks_append_bit_for_bit(buffer: ReferenceBuffer, values: FloatArray) -> None:
    buffer.append(chunk(0, 20, values))
    buffer.append(chunk(20, 40, values))
    taken = [buffer.take(stamp_ns(k, T)) for k in range(60)]
    assert np.array_equal(np.array(taken), values)


def test_missing_chunk_shows_as_a_gap(buffer: ReferenceBuffer, values: FloatArray) -> None:
    buffer.append(chunk(0, 20, values))
    buffer.append(chunk(40, 20, values))
    assert buffer.take(stamp_ns(19, T)) is not None
    assert buffer.take(stamp_ns(20, T)) is None
    buffer.append(chunk(20, 20, values))
    assert np.array_equal(buffer.take(stamp_ns(20, T)), values[20])


def test_repeated_chunk_changes_nothing(buffer: ReferenceBuffer, values: FloatArray) -> None:
    buffer.append(chunk(0, 20, values))
    for k in range(10):
        buffer.take(stamp_ns(k, T))
    buffer.append(chunk(0, 20, values))
    assert len(buffer) == 10
    assert buffer.take(stamp_ns(9, T)) is None


def test_points_between_samples_are_refused(buffer: ReferenceBuffer) -> None:
    off_grid = JointTrajectoryChunk(stamp_ns(0, T), NAMES, np.array([0, 700_000]), np.zeros((2, 2)))
    with pytest.raises(RunError, match=r"between two sampling instants of 0\.0005 s; stream one point per sample"):
        buffer.append(off_grid)


def test_values_that_are_not_finite_are_refused(buffer: ReferenceBuffer, values: FloatArray) -> None:
    values[3, 5] = np.nan
    with pytest.raises(RunError, match="not a finite number"):
        buffer.append(chunk(0, 20, values))


def test_points_without_positions_are_refused(buffer: ReferenceBuffer) -> None:
    with pytest.raises(RunError, match="has no positions"):
        buffer.append(JointTrajectoryChunk(stamp_ns(0, T), NAMES, np.array([0]), effort=np.zeros((1, 2))))


def test_trajectory_replaces_what_was_buffered(buffer: ReferenceBuffer, values: FloatArray) -> None:
    buffer.append(chunk(0, 60, values))
    buffer.take(stamp_ns(0, T))
    target = np.array([[1.0, -2.0]])
    buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([5_000_000]), target))
    middle = buffer.take(stamp_ns(5, T))
    assert middle is not None
    assert middle[:2] == pytest.approx((values[0, :2] + target[0]) / 2)
    end = buffer.take(stamp_ns(10, T))
    assert end is not None
    assert end[:2] == pytest.approx(target[0])


def test_end_of_a_trajectory_is_held_at_rest(buffer: ReferenceBuffer) -> None:
    positions = np.array([[0.0, 0.0], [1.0, 2.0]])
    buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([500_000, 5_000_000]), positions))
    row = buffer.take(stamp_ns(1000, T))
    assert row is not None
    assert row.tolist() == [1.0, 2.0, 0.0, 0.0, 0.0, 0.0]


def test_stream_is_ignored_after_a_replacing_trajectory(buffer: ReferenceBuffer, values: FloatArray) -> None:
    buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([5_000_000]), np.ones((1, 2))))
    buffer.append(chunk(0, 60, values))
    assert buffer.ignored == 1
    row = buffer.take(stamp_ns(20, T))
    assert row is not None
    assert row[:2].tolist() == [1.0, 1.0]


def test_interpolation_with_velocities_reproduces_a_cubic(buffer: ReferenceBuffer) -> None:
    time = np.array([0.0, 0.01, 0.03])
    positions = np.column_stack([time**3 - time, 2 * time**2])
    velocities = np.column_stack([3 * time**2 - 1, 4 * time])
    stamps = (time * 1e9).astype(np.int64)
    buffer.replace(JointTrajectoryChunk(stamp_ns(0, T), NAMES, stamps, positions, velocities))
    for k in (1, 7, 20, 33, 59):
        t, row = k * T, buffer.take(stamp_ns(k, T))
        assert row is not None
        assert row[:4] == pytest.approx([t**3 - t, 2 * t**2, 3 * t**2 - 1, 4 * t], abs=1e-12)


def test_trajectory_whose_times_do_not_increase_is_refused(buffer: ReferenceBuffer) -> None:
    with pytest.raises(RunError, match="its times do not increase from 0 on"):
        buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([10, 10]), np.zeros((2, 2))))


def test_long_trajectory_of_two_points_costs_no_memory(buffer: ReferenceBuffer) -> None:
    tracemalloc.start()
    buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([0, 10**15]), np.array([[0.0, 0.0], [1.0, 1.0]])))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1_000_000
    row = buffer.take(stamp_ns(0, T) + 10**15 // 4)
    assert row is not None
    assert row[:2].tolist() == [0.25, 0.25]


def test_samples_that_a_real_time_loop_missed_are_forgotten(buffer: ReferenceBuffer, values: FloatArray) -> None:
    buffer.append(chunk(0, 60, values))
    assert buffer.take(stamp_ns(40, T)) is not None
    assert len(buffer) == 19
    buffer.append(chunk(0, 60, values))
    assert len(buffer) == 19


def test_chunk_for_the_awaited_sample_is_used(buffer: ReferenceBuffer, values: FloatArray) -> None:
    assert buffer.take(stamp_ns(20, T)) is None
    buffer.append(chunk(0, 60, values))
    assert np.array_equal(buffer.take(stamp_ns(20, T)), values[20])


def test_stream_too_far_ahead_is_refused(buffer: ReferenceBuffer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reference_buffer, "MOST_ROWS", 50)
    with pytest.raises(RunError, match="is 60 samples ahead of the loop, allowed are 50; stream it later"):
        buffer.append(chunk(0, 60, np.zeros((60, 6))))


def test_trajectory_of_too_many_points_is_refused(buffer: ReferenceBuffer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trajectory_request, "MOST_POINTS", 3)
    with pytest.raises(RunError, match="has 4 points, allowed are 3; send fewer,"):
        buffer.replace(JointTrajectoryChunk(0, NAMES, np.arange(1, 5), np.zeros((4, 2))))


def test_first_trajectory_leads_from_the_measured_position(buffer: ReferenceBuffer) -> None:
    buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([1_000_000]), np.array([[2.0, 4.0]])))
    start = buffer.take(stamp_ns(0, T), (1.0, 2.0))
    middle = buffer.take(stamp_ns(1, T), (9.0, 9.0))
    assert start is not None
    assert middle is not None
    assert start[:2].tolist() == [1.0, 2.0]
    assert middle[:2].tolist() == [1.5, 3.0]


def test_trajectory_with_a_stamp_begins_then(buffer: ReferenceBuffer) -> None:
    chunk = JointTrajectoryChunk(stamp_ns(10, T), NAMES, np.array([0, 5_000_000]), np.array([[0.0, 0.0], [1.0, 1.0]]))
    buffer.replace(chunk)
    rows = {k: buffer.take(stamp_ns(k, T), (0.0, 0.0)) for k in (0, 10, 15, 20)}
    assert [row[0] for row in rows.values() if row is not None] == pytest.approx([0.0, 0.0, 0.5, 1.0])


def test_trajectory_that_began_before_is_followed_from_where_it_is_now(buffer: ReferenceBuffer) -> None:
    buffer.replace(JointTrajectoryChunk(0, NAMES, np.array([0]), np.zeros((1, 2))))
    buffer.take(stamp_ns(100, T))
    late = JointTrajectoryChunk(stamp_ns(0, T), NAMES, np.array([0, 100_000_000]), np.array([[0.0, 0.0], [2.0, 2.0]]))
    buffer.replace(late)
    row = buffer.take(stamp_ns(101, T))
    assert row is not None
    assert row[0] == pytest.approx(2.0 * 101 / 200)


def test_refused_trajectory_leaves_what_was_held(buffer: ReferenceBuffer, values: FloatArray) -> None:
    buffer.append(chunk(0, 60, values))
    buffer.take(stamp_ns(40, T))
    with pytest.raises(RunError, match="it ends at 1.0050 s of simulated time, in the past: it is 1.0200 s"):
        buffer.replace(JointTrajectoryChunk(stamp_ns(0, T), NAMES, np.array([5_000_000]), np.zeros((1, 2))))
    assert np.array_equal(buffer.take(stamp_ns(41, T)), values[41])


def test_rest_row_slows_down_evenly(buffer: ReferenceBuffer) -> None:
    positions, speed = np.array([[0.0, 0.0], [1.0, 2.0]]), np.array([[1.0, 2.0], [1.0, 2.0]])
    buffer.replace(JointTrajectoryChunk(stamp_ns(0, T), NAMES, np.array([0, 10**9]), positions, speed))
    begin = buffer.take(stamp_ns(200, T))
    buffer.come_to_rest(0.1)
    half, end = buffer.take(stamp_ns(300, T)), buffer.take(stamp_ns(500, T))
    assert begin is not None
    assert half is not None
    assert end is not None
    assert half[:4] == pytest.approx([0.1 + 0.0375, 0.2 + 0.075, 0.5, 1.0])
    assert end[:4] == pytest.approx([0.15, 0.3, 0.0, 0.0])


def test_without_a_reference_there_is_nothing_to_bring_to_rest(buffer: ReferenceBuffer) -> None:
    buffer.come_to_rest(0.1)
    assert buffer.take(stamp_ns(0, T)) is None
