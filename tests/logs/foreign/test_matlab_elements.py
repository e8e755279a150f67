"""The elements of a MATLAB file are counted before SciPy unpacks them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from scipy.sparse import csc_array

from flexros.errors import InputError
from flexros.input_limits import DEEPEST_STRUCTURE
from flexros.logs.foreign.matlab_elements import check_elements


def cells() -> np.ndarray:
    made = np.empty((2, 2), object)
    made[:] = [[1, "a"], [np.ones(3), {"z": np.ones((3, 2))}]]
    return made


CONTENT = {
    "numbers": np.arange(5.0),
    "complex": np.ones(3) * 1j,
    "bytes": np.arange(3, dtype=np.uint8),
    "truth": np.array([True, False]),
    "empty": np.zeros((0, 0)),
    "text": ["abc", "de"],
    "sparse": csc_array(np.eye(4)),
    "cells": cells(),
    "structure": {"a": np.ones((4, 2)), "b": {"c": "text", "d": cells()}},
    "structures": np.zeros(3, dtype=[("q", float), ("r", float)]),
}


def nested(levels: int) -> Any:
    inner: Any = 1.0
    for _ in range(levels):
        inner = {"a": inner}
    return inner


@pytest.mark.parametrize("compressed", [True, False])
@pytest.mark.parametrize("kind", CONTENT)
def test_every_kind_of_array_is_passed(tmp_path: Path, kind: str, compressed: bool) -> None:
    savemat(tmp_path / "a.mat", {kind: CONTENT[kind], "last": 1.0}, do_compression=compressed)
    check_elements(tmp_path / "a.mat")


def test_version_4_has_nothing_to_check(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"q": np.arange(5.0)}, format="4")
    check_elements(tmp_path / "a.mat")


@pytest.mark.parametrize("compressed", [True, False])
def test_depth_is_limited(tmp_path: Path, compressed: bool) -> None:
    savemat(tmp_path / "a.mat", {"s": nested(DEEPEST_STRUCTURE - 1)}, do_compression=compressed)
    check_elements(tmp_path / "a.mat")
    savemat(tmp_path / "a.mat", {"s": nested(DEEPEST_STRUCTURE)}, do_compression=compressed)
    with pytest.raises(InputError, match="its structures nest more than 20 levels deep"):
        check_elements(tmp_path / "a.mat")


@pytest.mark.slow
def test_number_of_arrays_is_limited(tmp_path: Path) -> None:
    many = np.empty(100_001, object)
    many[:] = 0
    savemat(tmp_path / "a.mat", {"c": many}, do_compression=True)
    with pytest.raises(InputError, match="it holds more than 100000 arrays and structures"):
        check_elements(tmp_path / "a.mat")


def test_unpacked_size_is_limited(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"q": np.zeros(4_000_000)}, do_compression=True)
    with pytest.raises(InputError, match="its arrays unpack to more bytes than are allowed for a file of this size"):
        check_elements(tmp_path / "a.mat")


def test_truncated_variable_is_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"s": nested(3)}, do_compression=False)
    content = (tmp_path / "a.mat").read_bytes()
    (tmp_path / "a.mat").write_bytes(content[:200])
    with pytest.raises(InputError, match="truncated"):
        check_elements(tmp_path / "a.mat")


def test_element_of_an_unknown_type_is_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"q": np.arange(5.0)}, do_compression=False)
    content = bytearray((tmp_path / "a.mat").read_bytes())
    content[content.index(b"\x09\0\0\0\x28") + 1] = 8  # the tag of 40 bytes of doubles
    (tmp_path / "a.mat").write_bytes(content)
    with pytest.raises(InputError, match="a variable holds an element of the unknown type 2057"):
        check_elements(tmp_path / "a.mat")
