"""MATLAB files."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from flexros.errors import InputError
from flexros.logs.foreign.sources.matlab_file import MatlabFile


def test_vectors_matrices_and_structures(tmp_path: Path) -> None:
    file = tmp_path / "log.mat"
    q = np.arange(8.0).reshape(4, 2)
    savemat(file, {"t": np.arange(4.0)[:, None], "log": {"q": q}, "gain": 3.0, "who": "me"})
    opened = MatlabFile(file)
    assert sorted(opened.names) == ["log.q[0]", "log.q[1]", "t"]
    np.testing.assert_array_equal(opened.read(["log.q[1]"])["log.q[1]"].values, q[:, 1])


def test_damaged_file(tmp_path: Path) -> None:
    file = tmp_path / "log.mat"
    file.write_bytes(b"no MATLAB file at all" * 20)
    with pytest.raises(InputError, match="cannot be read as a MATLAB file .*save it again with: save -v7"):
        MatlabFile(file)


def test_version_7_3_without_h5py(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "log.mat"
    file.write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n" + bytes(100))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="version 7.3 .HDF5., which needs the package h5py: pip install h5py, or save"):
        MatlabFile(file)


def test_version_7_3_with_h5py(tmp_path: Path) -> None:
    file = tmp_path / "log.mat"
    q = np.arange(8.0).reshape(4, 2)
    with h5py.File(file, "w", userblock_size=512) as content:
        content["t"] = np.arange(4.0)[None, :]
        content["log/q"] = q.T  # MATLAB stores columns first
        content.create_dataset("name", data=np.zeros((1, 5), np.uint16)).attrs["MATLAB_class"] = np.bytes_("char")
    opened = MatlabFile(file)
    assert sorted(opened.names) == ["log.q[0]", "log.q[1]", "t"]
    np.testing.assert_array_equal(opened.read(["log.q[1]"])["log.q[1]"].values, q[:, 1])
