"""Matrices of a linear controller in a file: NumPy, MATLAB, JSON or YAML."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

REQUIRED = ("A", "B", "C", "D")
_TIMES = ("sample_time", "dt", "Ts")
_FORMATS = (".npz", ".mat", ".json", ".yaml", ".yml")


def read_matrices(file: str | Path) -> dict[str, Any]:
    """Read A, B, C, D, and where given anti_windup, inputs and the sample time.

    Args:
        file: Path of a .npz, .mat, .json or .yaml file with these names; the sample time [s] is sample_time, dt or Ts.

    Returns:
        Settings of the control law `state_space`.

    Raises:
        InputError: The file cannot be read, or lacks a matrix.
    """
    path = Path(file)
    content = _content(path)
    missing = [name for name in REQUIRED if name not in content]
    if missing:
        found = ", ".join(sorted(name for name in content if not name.startswith("__"))) or "nothing"
        raise InputError(f"{path}: {', '.join(missing)} is missing, found are {found}; add it")
    settings: dict[str, Any] = {}
    for name in (*REQUIRED, *(name for name in ("anti_windup",) if name in content)):
        try:
            if np.iscomplexobj(content[name]) and np.any(np.imag(content[name])):
                raise ValueError("it has complex numbers; bring the system to a real form")
            settings[name] = np.atleast_2d(np.asarray(content[name], dtype=float)).tolist()
        except (TypeError, ValueError) as error:
            raise InputError(f"{path}: {name} is not a matrix of numbers ({error}); correct it") from error
    if np.size(content["A"]) == 0:
        motors = len(np.atleast_2d(content["D"]))
        settings |= {"A": [], "B": [], "C": [[]] * motors}
    time = next((content[name] for name in _TIMES if name in content), None)
    if time is not None:
        try:
            (settings["matrices_sample_time"],) = np.ravel(np.asarray(time, dtype=float)).tolist()
        except (TypeError, ValueError) as error:
            raise InputError(f"{path}: the sample time is {time!r}, but must be one number [s]; correct it") from error
    if "inputs" in content:
        settings["inputs"] = [str(name).strip() for name in np.ravel(content["inputs"])]
    return settings


def matrices_text(matrices: Mapping[str, Any], indent: str = "") -> str:
    """Return YAML text of matrices, one row per line."""
    lines = []
    for name, value in matrices.items():
        if isinstance(value, np.ndarray) and value.ndim == 2:
            rows = ["[" + ", ".join(repr(float(entry)) for entry in row) + "]" for row in value]
            lines.append(f"{indent}{name}:" + ("" if rows else " []"))
            lines += [f"{indent}  - {row}" for row in rows]
        else:
            lines.append(f"{indent}{name}: {value}")
    return "\n".join(lines) + "\n"


def _content(path: Path) -> Mapping[str, Any]:
    """Return what a file holds, by name."""
    if path.suffix not in _FORMATS:
        raise InputError(f"'{path}' is no file of matrices, allowed are {', '.join(_FORMATS)}; give another file")
    if not path.is_file():
        raise InputError(f"the file of matrices '{path}' does not exist; give the path of one")
    try:
        if path.suffix == ".npz":
            with np.load(path, allow_pickle=False) as archive:
                return {name: archive[name] for name in archive.files}
        if path.suffix == ".mat":
            from scipy.io import loadmat  # here, because it loads slowly

            content: Mapping[str, Any] = loadmat(path)
            return content
    except Exception as error:  # readers of damaged files fail in many ways: EOFError, zlib.error, MatReadError
        raise InputError(f"'{path}' cannot be read as matrices ({error}); write it again") from error
    return read_yaml(path)  # JSON is YAML
