"""Opening files of foreign logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.foreign.signal_source import flatten, open_source


def test_suffix_in_capitals(tmp_path: Path) -> None:
    file = tmp_path / "LOG.CSV"
    file.write_text("t,q\n0,1\n")
    assert open_source(file).names == ("t", "q")


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no file .*none.csv; give the path"):
        open_source(tmp_path / "none.csv")


def test_unknown_format(tmp_path: Path) -> None:
    file = tmp_path / "log.xlsx"
    file.write_text("")
    with pytest.raises(
        InputError, match=r"ends with '.xlsx', but allowed are .*\.mat \(MATLAB\), \.npz \(NumPy archive\)"
    ):
        open_source(file)


def test_bag_of_ros_1_is_told_how_to_convert(tmp_path: Path) -> None:
    file = tmp_path / "run.bag"
    file.write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(InputError, match=r"run\.bag is a bag of ROS 1; convert it .* rosbags-convert"):
        open_source(file)


def test_file_without_arrays_of_numbers_is_refused(tmp_path: Path) -> None:
    from scipy.io import savemat

    cells = np.empty(2, dtype=object)
    cells[:] = [np.arange(3.0), np.arange(4.0)]
    savemat(tmp_path / "pieces.mat", {"q": cells, "dt": 0.001})
    with pytest.raises(
        InputError, match="holds no vector or matrix of numbers; objects, tables and texts are not read, nor cells"
    ):
        open_source(tmp_path / "pieces.mat")


def test_matrices_and_structures_are_columns() -> None:
    matrix = np.arange(6.0).reshape(3, 2)
    columns = flatten({"a": {"q": matrix, "gain": 3.0}, "text": "x", "row": np.ones((1, 4)), "c": np.ones(3) * 1j})
    assert list(columns) == ["a.q[0]", "a.q[1]", "row"]
    np.testing.assert_array_equal(columns["a.q[1]"], [1, 3, 5])
    assert columns["row"].shape == (4,)


def test_samples_of_a_matrix_are_along_its_longer_side() -> None:
    matrix = np.arange(6.0).reshape(3, 2)
    wide, long = flatten({"q": matrix.T}), flatten({"q": matrix})
    assert list(wide) == ["q[0]", "q[1]"]
    np.testing.assert_array_equal(wide["q[1]"], long["q[1]"])


def test_cells_of_equal_vectors_are_samples(tmp_path: Path) -> None:
    """As of a script that keeps the joints of each sample in a cell."""
    from scipy.io import savemat

    q = np.arange(6.0).reshape(3, 2)
    cells, mixed = np.empty((3, 1), dtype=object), np.empty(2, dtype=object)
    cells[:, 0] = [row[:, None] for row in q]
    mixed[:] = [np.arange(3.0), "text"]
    savemat(tmp_path / "log.mat", {"q": cells, "mixed": mixed, "t": np.arange(3.0)})
    source = open_source(tmp_path / "log.mat")
    assert sorted(source.names) == ["q[0]", "q[1]", "t"]
    np.testing.assert_array_equal(source.read(["q[1]"])["q[1]"].values, q[:, 1])
