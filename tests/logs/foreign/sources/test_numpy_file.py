"""NumPy archives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.foreign.sources.numpy_file import NumpyFile


def test_arrays_and_fields(tmp_path: Path) -> None:
    file = tmp_path / "log.npz"
    record = np.zeros(3, dtype=[("q", float), ("u", float)])
    record["u"] = [1, 2, 3]
    np.savez(file, t=np.arange(3), log=record)
    opened = NumpyFile(file)
    assert opened.names == ("t", "log.q", "log.u")
    np.testing.assert_array_equal(opened.read(["log.u"])["log.u"].values, [1, 2, 3])


def test_objects_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "log.npz"
    np.savez(file, t=np.array([{}, 1], dtype=object))
    with pytest.raises(InputError, match="cannot be read as a NumPy archive of plain arrays"):
        NumpyFile(file)


def test_damaged_file(tmp_path: Path) -> None:
    file = tmp_path / "log.npz"
    file.write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(InputError, match="write it with numpy.savez"):
        NumpyFile(file)
