from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.trajectory.arc import Arc
from flexros.trajectory.path import AbstractPath
from flexros.trajectory.sequence import Sequence
from flexros.trajectory.specification import TrajectorySpecification

PLANE = np.array([2.0, -0.3])
SPACE = np.array([1.0, 0.2, 0.7])
POSE = np.array([1.0, 0.2, 0.7, 0.3, 0.2, -0.5])
TURNED = Rotation.from_euler("xyz", [-0.8, 0.6, 1.2]).as_quat().tolist()


def paths(start: np.ndarray, n_position: int | None = None, **path: object) -> tuple[AbstractPath, ...]:
    data = {"path": path, "time_law": {"type": "ninth_degree", "duration": 1.0}}
    specification = validate(TrajectorySpecification, data, "scenario.yaml, key trajectory")
    return specification.path.paths(start, min(3, start.size) if n_position is None else n_position)


def test_circle_by_its_centre() -> None:
    (path,) = paths(PLANE, type="circle", centre_from_start=[-0.025, 0.0])
    assert isinstance(path, Arc)
    assert (path.radius, path.start_angle, path.angle) == (0.025, 0.0, 2 * np.pi)


def test_circle_by_radius_and_start_angle() -> None:
    (path,) = paths(PLANE, type="circle", radius=0.1, start_angle=np.pi / 2, turns=-2)
    assert isinstance(path, Arc)
    np.testing.assert_allclose(path.centre, PLANE - [0.0, 0.1])
    assert path.angle == -4 * np.pi


def test_circle_may_say_the_same_twice() -> None:
    (path,) = paths(PLANE, type="circle", radius=0.025, centre_from_start=[-0.025, 0.0], start_angle=0, turns=1)
    np.testing.assert_allclose(path.start, PLANE)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            {"radius": 0.03},
            "radius 0.03 m but its centre_from_start is 0.025 m away, allowed are equal numbers; leave one",
        ),
        (
            {"start_angle": 1.5},
            "start_angle 1.5 rad but its centre_from_start means .* allowed are equal angles; leave one",
        ),
    ],
)
def test_circle_that_contradicts_itself_is_refused(keys: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        paths(PLANE, type="circle", centre_from_start=[-0.025, 0.0], **keys)


def test_circle_in_space_is_in_its_plane() -> None:
    (path,) = paths(SPACE, type="circle", centre_from_start=[0.0, 0.1, 0.0], plane="yz", turns=0.25)
    np.testing.assert_allclose(path.end, SPACE + np.array([0.0, 0.1, -0.1]), atol=1e-12)
    with pytest.raises(
        InputError, match="allowed is a displacement within the plane xz; correct centre_from_start or plane"
    ):
        paths(SPACE, type="circle", centre_from_start=[0.0, 0.1, 0.0], plane="xz")


@pytest.mark.parametrize("keys", [{"end": [2.5, 0.1]}, {"end_from_start": [0.5, 0.4]}])
def test_line_to_a_point_or_by_a_displacement(keys: dict[str, list[float]]) -> None:
    (path,) = paths(PLANE, type="line", **keys)
    np.testing.assert_allclose(path.end, [2.5, 0.1])


def test_positions_alone_keep_the_angles() -> None:
    (path,) = paths(POSE, type="line", end=[1.5, 0.2, 0.7])
    np.testing.assert_allclose(path.end[3:], POSE[3:], atol=1e-15)
    (path,) = paths(np.array([2.0, -0.3, 0.4]), 2, type="circle", radius=0.1)
    assert path.n_out == 3
    np.testing.assert_allclose(path.derivatives(np.linspace(0, 6, 9), 1)[:, :, 2], [[0.4] * 9, [0.0] * 9])


def test_all_coordinates_may_be_given() -> None:
    (path,) = paths(np.array([2.0, -0.3, 0.4]), 2, type="line", end=[2.0, 0.7, 0.9])
    np.testing.assert_allclose(path.end, [2.0, 0.7, 0.9])
    assert path.extent == 1.0


@pytest.mark.parametrize(
    "keys",
    [
        {"type": "line", "end_from_start": [0.1, 0.0, 0.0]},
        {"type": "line"},
        {"type": "circle", "radius": 0.1},
        {"type": "arc", "centre_from_start": [0.1, 0.0, 0.0], "angle": 1.0, "normal": [0, 1, 0]},
    ],
)
def test_every_tool_path_can_turn(keys: dict[str, object]) -> None:
    (path,) = paths(POSE, end_orientation=TURNED, **keys)
    np.testing.assert_allclose(path.start, POSE, atol=1e-12)
    np.testing.assert_allclose(path.end[3:], [-0.8, 0.6, 1.2], atol=1e-12)


def test_lines_with_orientations_and_zones() -> None:
    points = [[0.2, 0.0, 0.0], [0.2, 0.3, 0.0]]
    (path,) = paths(POSE, type="lines", points_from_start=points, orientations=[TURNED, TURNED], zone=0.05)
    np.testing.assert_allclose(path.end[3:], [-0.8, 0.6, 1.2], atol=1e-12)
    assert len(paths(POSE, type="lines", points_from_start=points, orientations=[TURNED, TURNED])) == 2
    with pytest.raises(
        InputError, match="there are 1 orientations for 2 points, allowed is one per point; correct the list"
    ):
        paths(POSE, type="lines", points_from_start=points, orientations=[TURNED])


def test_turning_needs_six_coordinates() -> None:
    with pytest.raises(InputError, match="the path turns the tool but the output has 2 coordinates, allowed are six"):
        paths(PLANE, type="line", end_orientation=TURNED)


def test_arc_in_its_three_forms() -> None:
    for keys in (
        {"via": [2.1, -0.2], "end": [2.2, -0.3]},
        {"via_from_start": [0.1, 0.1], "end_from_start": [0.2, 0.0]},
        {"centre_from_start": [0.1, 0.0], "angle": -np.pi},
    ):
        (path,) = paths(PLANE, type="arc", **keys)
        assert isinstance(path, Arc)
        np.testing.assert_allclose(path.centre, [2.1, -0.3], atol=1e-12)
        np.testing.assert_allclose(path.end, [2.2, -0.3], atol=1e-12)


def test_arc_of_mixed_keys_is_refused() -> None:
    with pytest.raises(
        InputError, match="the arc has the keys angle, via, allowed are via and end, .*; give one of these"
    ):
        paths(PLANE, type="arc", via=[1, 2], angle=1.0)


def test_collinear_arc_is_refused() -> None:
    with pytest.raises(InputError, match="collinear"):
        paths(PLANE, type="arc", via_from_start=[0.1, 0.1], end_from_start=[0.2, 0.2])


def test_points_stop_without_zone_and_are_rounded_with_one() -> None:
    points = [[0.2, 0.0], [0.2, 0.3]]
    assert len(paths(PLANE, type="lines", points_from_start=points)) == 2
    (path,) = paths(PLANE, type="lines", points_from_start=points, zone=[0.05])
    assert isinstance(path, Sequence)
    np.testing.assert_allclose(path.end, PLANE + np.array([0.2, 0.3]))


def test_joint_moves_absolute_and_relative() -> None:
    home = np.array([0.1, 0.2, 0.3])
    absolute = paths(home, type="joint_moves", points=[[0.5, 0.2, 0.3], [0.5, 0.9, 0.3]])
    relative = paths(home, type="joint_moves", points_from_start=[[0.4, 0.0, 0.0], [0.4, 0.7, 0.0]])
    for one, two in zip(absolute, relative, strict=True):
        np.testing.assert_allclose(one.end, two.end)
    (path,) = paths(home, type="joint_moves", points=[[0.5, 0.2, 0.3], [0.5, 0.9, 0.3]], zone=0.1)
    assert isinstance(path, Sequence)
    assert path.joints


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ({"type": "line"}, "no end is given, allowed are end, end_from_start, end_orientation; add one"),
        (
            {"type": "line", "end": [1, 2], "end_from_start": [1, 2]},
            "both end and end_from_start are given, .* leave one out",
        ),
        ({"type": "circle"}, "neither radius nor centre_from_start, allowed is one or both; add radius"),
        ({"type": "circle", "radius": 0}, "radius' is 0, but input should be greater than 0; correct the value"),
        ({"type": "circle", "radius": float("nan")}, "radius' is nan, but"),
        ({"type": "lines"}, "give either points or points_from_start; correct the path"),
        ({"type": "joint_moves", "points": []}, "points' is"),
        ({"type": "spiral"}, "allowed|expected"),
        ({"type": "circle", "radius": 1, "radus": 2}, "unknown key 'path.*radus'"),
    ],
)
def test_bad_keys_are_refused_with_their_source(path: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=rf"scenario.yaml, key trajectory: .*{message}"):
        paths(PLANE, **path)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ({"type": "line", "end": [1.0, 2.0, 3.0]}, "the end of the line has 3 coordinates, allowed are 2"),
        ({"type": "lines", "points": [[1.0]]}, "the point 1 of the lines has 1 coordinates, allowed are 2"),
        ({"type": "joint_moves", "points": [[1.0]]}, "the point 1 of the joint moves has 1 coordinates, allowed are 2"),
        ({"type": "circle", "centre_from_start": [1.0]}, "the centre_from_start of the circle has 1 coordinates"),
        ({"type": "arc", "via": [1.0], "end": [1.0]}, "the via point of the arc has 1 coordinates"),
    ],
)
def test_points_of_wrong_size_are_named(path: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        paths(PLANE, **path)
