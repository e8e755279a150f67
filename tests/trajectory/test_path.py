"""Laws that every path keeps."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.trajectory.arc import Arc, circle
from flexros.trajectory.line import JointMove, Line
from flexros.trajectory.orientation import Extended, RollPitchYaw, quaternion_of
from flexros.trajectory.path import AbstractPath, point
from flexros.trajectory.sequence import Sequence

PATHS: dict[str, AbstractPath] = {
    "line in a plane": Line(np.array([1.0, 2.0]), np.array([-0.5, 2.5])),
    "line in space": Line(np.array([1.0, 2.0, 0.3]), np.array([-0.5, 2.5, 0.1])),
    "turn on the spot": Line(np.array([1.0, 2.0, 0.3, 0.0, 0.0, 0.0]), np.array([1.0, 2.0, 0.3, 0.5, -0.2, 0.1])),
    "joint move": JointMove(np.array([0.1, 0.2, 0.3]), np.array([0.5, 0.2, -0.3])),
    "circle": circle(np.array([2.1, -0.35]), 0.025, 0.4, 1.5),
    "clockwise circle in space": circle(np.array([2.1, -0.35, 1.0]), 0.2, 0.4, -1.0, "xz"),
    "arc about": Arc.about(np.zeros(3), np.array([1.0, 0.0, 0.0]), -2.0, np.array([0.0, 1.0, 1.0])),
    "arc through": Arc.through(np.array([1.0, 0.0]), np.array([0.8, 0.7]), np.array([0.0, 1.0])),
    "rounded lines": Sequence([[0.0, 0.0], [1.0, 0.2], [0.8, 1.0], [0.0, 0.9]], [0.1, 0.3]),
    "rounded joint moves": Sequence([[0.0, 0.0, 0.0], [1.0, 0.2, -1.0], [0.8, 1.0, 3.0]], 0.5, joints=True),
    "line with turn": RollPitchYaw(
        Line(np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]), np.array([1.5, 2.0, 3.0, 0.4, -0.3, 1.1])),
        quaternion_of(np.array([0.3, 0.2, -0.5])),
    ),
    "circle with turn": RollPitchYaw(
        Extended(circle(np.zeros(3), 0.3), np.zeros(3), np.array([0.4, -0.3, 1.1])),
        quaternion_of(np.array([0.3, 0.2, -0.5])),
    ),
    "rounded lines with turns": RollPitchYaw(
        Sequence([[0.0, 0, 0, 0, 0, 0], [1.0, 0, 0, 0.4, 0.1, 0], [1.0, 1.0, 0, -0.2, 0.3, 0.8]], 0.2, n_position=3),
        quaternion_of(np.array([0.3, 0.2, -0.5])),
    ),
}


@pytest.mark.parametrize("name", PATHS)
def test_derivatives_agree_with_differences(name: str) -> None:
    path = PATHS[name]
    h = 1e-4 * path.extent
    s = np.linspace(2.0 * h, path.extent - 2.0 * h, 97)
    around = [path.derivatives(s + k * h) for k in (-2, -1, 1, 2)]
    exact = path.derivatives(s)
    for order in range(1, 5):
        far_left, left, right, far_right = (values[order - 1] for values in around)
        difference = (far_left - 8.0 * left + 8.0 * right - far_right) / (12.0 * h)
        scale = np.max(np.abs(exact[order])) + np.max(np.abs(exact[order - 1])) / path.extent
        np.testing.assert_allclose(difference, exact[order], atol=2e-6 * scale)


@pytest.mark.parametrize("name", PATHS)
def test_fewer_derivatives_are_the_first_of_all(name: str) -> None:
    path = PATHS[name]
    s = np.linspace(0.0, path.extent, 11)
    for order in range(5):
        np.testing.assert_array_equal(path.derivatives(s, order), path.derivatives(s)[: order + 1])
    assert path.derivatives(s).shape == (5, 11, path.n_out)


@pytest.mark.parametrize("name", [name for name in PATHS if "turn" not in name])
def test_pace_bounds_the_length_per_parameter(name: str) -> None:
    path = PATHS[name]
    slope = path.derivatives(np.linspace(0.0, path.extent, 2001), 1)[1]
    speed = np.linalg.norm(slope, axis=1)
    assert np.max(speed) == pytest.approx(path.pace, rel=1e-9)
    assert np.all(np.max(np.abs(slope), axis=0) <= path.coordinate_pace * (1.0 + 1e-9))


def test_pace_of_a_path_that_turns_counts_the_positions() -> None:
    for name in ("line with turn", "circle with turn", "rounded lines with turns"):
        slope = PATHS[name].derivatives(np.linspace(0.0, PATHS[name].extent, 501), 1)[1]
        assert np.max(np.linalg.norm(slope[:, :3], axis=1)) == pytest.approx(PATHS[name].pace, rel=1e-9)
        assert PATHS[name].coordinate_pace.shape == (6,)
        assert PATHS[name].parameter_unit == PATHS[name].turning.parameter_unit


@pytest.mark.parametrize("values", [["a", 1.0], [[1.0, 2.0]], [], [1.0, float("nan")], [float("inf"), 0.0], None])
def test_bad_points_are_refused(values: object) -> None:
    with pytest.raises(InputError, match=r"the end of the line .* allowed .*; correct the point"):
        point(values, "end of the line")


def test_point_of_wrong_size_is_refused() -> None:
    with pytest.raises(InputError, match="the end has 3 coordinates, allowed are 2"):
        point([1, 2, 3], "end", 2)


def test_points_cannot_be_changed_afterwards() -> None:
    line = Line(np.array([0.0, 0.0]), np.array([1.0, 0.0]))
    with pytest.raises(ValueError, match="read-only"):
        line.start_point[0] = 5.0
