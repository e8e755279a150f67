from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.kinematics.record import PoseRecord, poses_text, read_poses
from flexros.robot import load_robot


def test_poses_are_read_as_written(tmp_path: Path) -> None:
    robot = load_robot("e12")
    record = PoseRecord(np.array([[0.1, 0.2], [0.3, 0.4]]), np.array([0.0, 20.0]), np.arange(6.0).reshape(2, 3))
    file = tmp_path / "poses.csv"
    file.write_text(poses_text(robot, record))
    again = read_poses(file, robot)
    np.testing.assert_allclose(again.motor_position, record.motor_position)
    np.testing.assert_allclose(again.load, record.load)
    np.testing.assert_allclose(again.tool, record.tool)


def test_load_may_be_missing(tmp_path: Path) -> None:
    file = tmp_path / "poses.csv"
    file.write_text("motor_1,motor_2,x,y,z\n0,0,1,2,3\n")
    assert read_poses(file, load_robot("e12")).load.tolist() == [0.0]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("motor_1,x,y,z\n0,1,2,3\n", "lacks the columns motor_2"),
        ("motor_1,motor_2,x,y,z\n0,0,1,2,nan\n", "line 2, column z is 'nan'"),
        ("motor_1,motor_2,x,y,z\n0,0,1,2\n", "line 2, column z"),
        ("motor_1,motor_2,x,y,z\n", "has no pose"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, sentence: str) -> None:
    file = tmp_path / "poses.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=sentence):
        read_poses(file, load_robot("e12"))
