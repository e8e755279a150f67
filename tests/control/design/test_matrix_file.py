"""Files with the matrices of a controller, also damaged ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from flexros.control.design.matrix_file import read_matrices
from flexros.errors import InputError

OTHERS = {name: np.eye(1) for name in "ABC"}
D = np.eye(1)


def written(folder: Path, name: str, **content: object) -> Path:
    file = folder / name
    if name.endswith(".mat"):
        savemat(file, content)
    else:
        np.savez(file, **content)  # type: ignore[arg-type]
    return file


@pytest.mark.parametrize("name", ["law.mat", "law.npz"])
def test_a_file_that_was_cut_is_refused_in_one_sentence(name: str, tmp_path: Path) -> None:
    file = written(tmp_path, name, D=D)
    for kept in (0, file.stat().st_size // 2):
        file.write_bytes(file.read_bytes()[:kept])
        with pytest.raises(InputError, match="cannot be read as matrices"):
            read_matrices(file)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ({"D": D, "dt": "1 ms"}, "the sample time is"),
        ({"D": D, "dt": []}, "the sample time is"),
        ({"D": np.array([[1 + 1j]])}, "it has complex numbers"),
    ],
)
def test_what_is_no_matrix_or_no_time_is_named(content: dict[str, object], told: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=told):
        read_matrices(written(tmp_path, "law.npz", **OTHERS, **content))
