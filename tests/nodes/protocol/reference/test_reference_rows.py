"""Rows of a reference: as planned, or brought to rest on the planned way."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from flexros.feedforward.motion import Reference
from flexros_nodes.protocol.reference.reference_rows import PlannedRows, RowsToRest

T, N = 1e-3, 2000
FIRST, SLOWING = 700, 300


def reference() -> Reference:
    time = np.arange(N) * T
    phase = np.stack([2 * np.pi * 3.0 * time, 2 * np.pi * 7.0 * time], axis=1)
    rate = 2 * np.pi * np.array([3.0, 7.0])
    pose = np.zeros((N, 7))
    pose[:, 0] = np.sin(phase[:, 0])
    pose[:, 3:] = np.random.default_rng(1).normal(size=(N, 4))
    pose[:, 3:] /= np.linalg.norm(pose[:, 3:], axis=1, keepdims=True)
    return Reference(time, np.sin(phase), np.cos(phase) * rate, np.ones((N, 2)), pose[:, :1], pose)


def test_planned_rows_are_those_of_the_reference() -> None:
    planned = reference()
    rows = PlannedRows(planned).rows(range(10, 30))
    assert np.array_equal(rows.motor_position, planned.motor_position[10:30])
    assert len(rows) == 20


def test_rows_before_the_stop_are_as_planned_to_the_last_bit() -> None:
    planned = reference()
    rows = RowsToRest(planned, FIRST, SLOWING, T).rows(range(FIRST + 1))
    for field in fields(Reference):
        assert np.array_equal(getattr(rows, field.name), getattr(planned, field.name)[: FIRST + 1]), field.name


def test_reference_rests_half_the_samples_after_the_stop() -> None:
    planned = reference()
    rows = RowsToRest(planned, FIRST, SLOWING, T).rows(range(FIRST + SLOWING, 2 * N))
    end = planned.motor_position[FIRST + SLOWING // 2]
    np.testing.assert_allclose(rows.motor_position, np.tile(end, (len(rows), 1)), rtol=0, atol=1e-12)
    assert np.array_equal(rows.motor_velocity, np.zeros((len(rows), 2)))


def test_speed_is_the_derivative_of_the_position_and_jumps_nowhere() -> None:
    rows = RowsToRest(reference(), FIRST, SLOWING, T).rows(range(N))
    numerical = np.gradient(rows.motor_position, T, axis=0)
    np.testing.assert_allclose(rows.motor_velocity[1:-1], numerical[1:-1], atol=2e-2)
    before = np.abs(np.diff(rows.motor_velocity[:FIRST], axis=0)).max()
    assert np.abs(np.diff(rows.motor_velocity, axis=0)).max() < 1.5 * before


def test_it_is_never_faster_than_planned() -> None:
    planned = reference()
    rows = RowsToRest(planned, FIRST, SLOWING, T).rows(range(N))
    assert (np.abs(rows.motor_velocity).max(axis=0) <= np.abs(planned.motor_velocity).max(axis=0) + 1e-9).all()


def test_quaternions_keep_their_length() -> None:
    rows = RowsToRest(reference(), FIRST, SLOWING, T).rows(range(N))
    np.testing.assert_allclose(np.linalg.norm(rows.tool_pose[:, 3:], axis=1), 1.0, atol=1e-12)


def test_stop_near_the_end_of_the_plan_holds_its_last_place() -> None:
    planned = reference()
    rows = RowsToRest(planned, N - 10, SLOWING, T).rows(range(N + SLOWING))
    assert np.array_equal(rows.motor_position[-1], planned.motor_position[-1])


def test_stop_before_the_first_sample_rests_at_the_initial_position() -> None:
    planned = reference()
    start = {f.name: np.repeat(getattr(planned, f.name)[:1], N, axis=0) for f in fields(Reference)}
    at_rest = Reference(**{**start, "motor_velocity": np.zeros((N, 2))})
    rows = RowsToRest(at_rest, 0, SLOWING, T).rows(range(500))
    np.testing.assert_allclose(rows.motor_position, at_rest.motor_position[:500], atol=1e-15)
