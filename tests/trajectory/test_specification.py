from __future__ import annotations

import re
from collections.abc import Mapping
from typing import get_args

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.trajectory.path_specification import PathSpecification
from flexros.trajectory.specification import TotalLimits, TrajectorySpecification, build_trajectory
from flexros.trajectory.time_law_specification import TimeLawSpecification
from flexros.trajectory.trajectory import Trajectory

CIRCLE = {"type": "circle", "radius": 0.025, "centre_from_start": [-0.025, 0], "start_angle": 0, "turns": 1}
LIMITS = {"type": "bang_bang_snap", "speed": 0.5, "acceleration": 15, "jerk": 900, "snap": 54000}
LINE = {"type": "line", "end_from_start": [-0.1, 0.0]}
SMOOTH = {"type": "ninth_degree", "duration": 0.8}
SOURCE = "scenario.yaml: trajectory"


def read(keys: Mapping[str, object]) -> TrajectorySpecification:
    return validate(TrajectorySpecification, keys, SOURCE)


def build(start: FloatArray, **keys: object) -> Trajectory:
    return build_trajectory(read(keys), start, source=SOURCE)


def test_circle_test_of_paper_b(start: FloatArray) -> None:
    trajectory = build(start, path=CIRCLE, time_law=LIMITS, hold_after=0.1)
    assert trajectory.duration == pytest.approx(0.48083, abs=5e-6)
    assert (trajectory.output, trajectory.n_out, trajectory.bounded_derivatives) == ("tool", 2, 4)
    np.testing.assert_allclose(trajectory.start, start, atol=1e-15)
    np.testing.assert_allclose(
        trajectory.evaluate(np.array([0.48083 / 2 - 0.05]), 0)[0, 0], start - [0.05, 0.0], atol=1e-4
    )


def test_smooth_case(start: FloatArray) -> None:
    trajectory = build(start, path=CIRCLE, time_law=SMOOTH, hold_before=0.2, hold_after=0.1)
    assert trajectory.duration == pytest.approx(1.1)
    s = 0.25
    angle = 2 * np.pi * (126 * s**5 - 420 * s**6 + 540 * s**7 - 315 * s**8 + 70 * s**9)
    expected = start + 0.025 * np.array([np.cos(angle) - 1.0, np.sin(angle)])
    np.testing.assert_allclose(trajectory.evaluate(np.array([0.4]), 0)[0, 0], expected, atol=1e-14)


def test_cycles_are_separated_by_the_dwell(start: FloatArray) -> None:
    trajectory = build(start, path=CIRCLE, time_law=SMOOTH, repeat=3, dwell=0.2, hold_before=0.1)
    assert trajectory.duration == pytest.approx(3 * 0.8 + 2 * 0.2 + 0.1)
    t = np.linspace(0.0, 0.8, 50)
    first, second, third = (trajectory.evaluate(t + begin) for begin in (0.1, 1.1, 2.1))
    np.testing.assert_allclose(first, second, atol=1e-8)
    np.testing.assert_allclose(first, third, atol=1e-8)
    np.testing.assert_array_equal(trajectory.evaluate(np.array([1.0]))[1:], 0.0)


def test_line_returns_to_its_start(start: FloatArray) -> None:
    trajectory = build(start, path=LINE, time_law=SMOOTH, return_to_start=True, repeat=2, dwell=0.1)
    assert trajectory.duration == pytest.approx(4 * 0.8 + 3 * 0.1)
    ends = trajectory.evaluate(np.array([0.85, 1.75, 2.65, 9.0]), 0)[0, :, 0]
    np.testing.assert_allclose(ends - start[0], [-0.1, 0.0, -0.1, 0.0], atol=1e-15)


def test_repeating_an_open_path_is_refused(start: FloatArray) -> None:
    with pytest.raises(
        InputError,
        match=f"{re.escape(SOURCE)}: the trajectory has repeat 2 but its path begins at .*, allowed is to "
        "repeat a path that ends where it begins; set return_to_start: true or repeat: 1",
    ):
        build(start, path=LINE, time_law=SMOOTH, repeat=2)


def test_joint_moves_stop_at_their_points_and_dwell() -> None:
    path = {"type": "joint_moves", "points": [[0.5, 0.3], [0.5, 0.9]]}
    trajectory = build(np.array([0.0, 0.3]), path=path, time_law=SMOOTH, dwell=0.2)
    assert trajectory.joints
    assert trajectory.duration == pytest.approx(1.8)
    np.testing.assert_allclose(trajectory.evaluate(np.array([0.9]))[:2, 0], [[0.5, 0.3], [0.0, 0.0]])
    assert read({"path": path, "time_law": SMOOTH}).joints


def test_joint_moves_with_limits_per_joint_keep_them() -> None:
    path = {"type": "joint_moves", "points": [[0.5, 0.3, 0.0], [0.5, 0.9, 1.0]], "zone": 0.2}
    law = {"type": "bang_bang_snap", "speed": [1.0, 0.5, 2.0], "acceleration": 5.0, "jerk": 100.0, "snap": 5e3}
    trajectory = build(np.zeros(3), path=path, time_law=law)
    speed = np.max(np.abs(trajectory.evaluate(trajectory.sample_times(2000), 1)[1]), axis=0)
    assert np.all(speed <= np.array([1.0, 0.5, 2.0]) * (1 + 1e-9))
    assert np.any(speed > 0.7 * np.array([1.0, 0.5, 2.0]))


def test_output_is_joints_for_joint_moves_else_the_key_else_the_controlled_one() -> None:
    moves = {"type": "joint_moves", "points": [[0.5, 0.3]]}
    assert read({"path": moves, "time_law": SMOOTH}).output_of("tool") == "joints"
    assert read({"path": LINE, "time_law": SMOOTH}).output_of("tip") == "tip"
    assert read({"path": LINE, "time_law": SMOOTH, "output": "tool"}).output_of("joints") == "tool"


def test_tool_path_for_joints_is_refused(start: FloatArray) -> None:
    specification = read({"path": LINE, "time_law": SMOOTH})
    with pytest.raises(
        InputError, match="the path type line moves the tool but the output is 'joints', .* or use joint_moves"
    ):
        build_trajectory(specification, start, output="joints")


def test_start_of_another_output_is_refused(start: FloatArray) -> None:
    with pytest.raises(
        InputError, match="trajectory is for output 'tip' but the start belongs to output 'tool', allowed"
    ):
        build(start, path=LINE, time_law=SMOOTH, output="tip")
    assert build(start, path=LINE, time_law=SMOOTH, output="tool").output == "tool"


def test_impossible_geometry_names_the_key_path(start: FloatArray) -> None:
    with pytest.raises(InputError, match=f"{re.escape(SOURCE)}.path: the line starts and ends at .* length is 0 m"):
        build(start, path={"type": "line", "end_from_start": [0, 0]}, time_law=SMOOTH)


def test_impossible_limits_name_the_key_time_law(start: FloatArray) -> None:
    with pytest.raises(
        InputError, match=f"{re.escape(SOURCE)}.time_law: the duration of the ninth_degree time law is 0.8 s"
    ):
        build(start, path=CIRCLE, time_law={**SMOOTH, "speed": 0.1})


def test_total_limits_are_checked(start: FloatArray) -> None:
    build(start, path=CIRCLE, time_law=LIMITS, total_limits={"acceleration": 15.3})
    with pytest.raises(InputError, match=f"{re.escape(SOURCE)}: the acceleration reaches 15.23.* slow the motion down"):
        build(start, path=CIRCLE, time_law=LIMITS, total_limits={"acceleration": 15.0})


def test_total_limits_left_out_are_infinite() -> None:
    assert TotalLimits(jerk=3.0).limits.values == (np.inf, np.inf, 3.0, np.inf)


def test_motion_of_more_than_an_hour_is_refused(start: FloatArray) -> None:
    with pytest.raises(
        InputError, match=r"the trajectory lasts 1.571e\+06 s, allowed are at most 3600 s; raise the limits of"
    ):
        build(start, path=CIRCLE, time_law={**LIMITS, "speed": 1e-7})


def test_start_must_be_finite(start: FloatArray) -> None:
    with pytest.raises(
        InputError, match=f"{re.escape(SOURCE)}.path: the start of the trajectory is .* allowed are finite"
    ):
        build(start * np.nan, path=CIRCLE, time_law=SMOOTH)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"time_law": SMOOTH}, "key 'path' is missing; add it"),
        ({"path": CIRCLE, "time_law": SMOOTH, "hold": 1.0}, "unknown key 'hold'"),
        (
            {"path": CIRCLE, "time_law": SMOOTH, "hold_after": -1.0},
            "key 'hold_after' is -1.0, but input should be greater",
        ),
        ({"path": CIRCLE, "time_law": SMOOTH, "repeat": 0}, "key 'repeat' is 0, but input should be greater"),
        (
            {"path": CIRCLE, "time_law": SMOOTH, "dwell": float("nan")},
            "key 'dwell' is nan, but input should be a finite",
        ),
    ],
)
def test_bad_keys_are_refused_with_their_source(keys: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=f"{re.escape(SOURCE)}: {message}"):
        read(keys)


def test_specification_survives_plain_data() -> None:
    specification = read({"path": CIRCLE, "time_law": LIMITS, "repeat": 2})
    assert read(specification.model_dump(mode="json", exclude_unset=True)) == specification


def test_every_key_says_what_it_means_and_in_which_unit() -> None:
    unions = (*get_args(get_args(PathSpecification)[0]), *get_args(get_args(TimeLawSpecification)[0]))
    for model in (TrajectorySpecification, TotalLimits, *unions):
        for name, field in model.model_fields.items():
            if name == "type":
                continue
            assert field.description, f"{model.__name__}.{name}"
            if any(kind in str(field.annotation) for kind in ("float", "Point", "Quaternion")):
                assert re.search(r"\[.+\]|\bm\b|points|the same", field.description), f"{model.__name__}.{name}"
