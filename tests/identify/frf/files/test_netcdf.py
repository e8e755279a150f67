"""Saving and loading frequency responses."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.distortion import Distortion
from flexros.identify.frf.files.netcdf import load_responses, save_responses
from flexros.identify.frf.frequency_response import FrequencyResponse


def response(n_lines: int, n: int = 2, errors: bool = True, distortion: bool = True) -> FrequencyResponse:
    rng = np.random.default_rng(n_lines)

    def matrices() -> np.ndarray:
        root = rng.standard_normal((n_lines, n, n)) + 1j * rng.standard_normal((n_lines, n, n))
        return np.asarray(root @ np.conj(np.swapaxes(root, 1, 2)))

    levels = {
        field.name: rng.random(3 if field.name.startswith(("odd", "even")) else n_lines)
        if field.name.endswith("frequency")
        else rng.random((3 if field.name.startswith(("odd", "even")) else n_lines, n))
        for field in fields(Distortion)
    }
    levels["frequency"] = np.arange(1.0, n_lines + 1)
    names = tuple(f"motor_{i + 1}" for i in range(n))
    return FrequencyResponse(
        frequency=np.arange(1.0, n_lines + 1),
        response=rng.standard_normal((n_lines, n, n)) + 1j * rng.standard_normal((n_lines, n, n)),
        noise_error=matrices() if errors else None,
        total_error=matrices() if errors else None,
        input_inverse=matrices(),
        degrees_of_freedom=14.5,
        input_names=names,
        output_names=names,
        input_units=("Nm",) * n,
        coordinate_units=("rad",) * n,
        gears=rng.random(n),
        motor_position=rng.random(n),
        sample_time=5e-4,
        n_periods=2,
        n_blocks=3,
        distortion=Distortion(**levels) if distortion else None,
        warnings=("the first; with a mark", "the second") if errors else (),
    )


def assert_equal(a: FrequencyResponse, b: FrequencyResponse) -> None:
    for field in fields(FrequencyResponse):
        left, right = getattr(a, field.name), getattr(b, field.name)
        if isinstance(left, Distortion):
            for level in fields(Distortion):
                np.testing.assert_array_equal(getattr(left, level.name), getattr(right, level.name))
        elif isinstance(left, np.ndarray):
            np.testing.assert_array_equal(left, right, err_msg=field.name)
            assert left.dtype == right.dtype
        else:
            assert left == right, field.name


def test_responses_come_back_bit_by_bit(tmp_path: Path) -> None:
    file = tmp_path / "responses.nc"
    written = (response(5), response(8, errors=False, distortion=False), response(3, n=1))
    save_responses(written, file)
    read = load_responses(file)
    assert len(read) == 3
    for a, b in zip(written, read):
        assert_equal(a, b)


def test_file_is_plain_netcdf(tmp_path: Path) -> None:
    from scipy.io import netcdf_file

    save_responses([response(4)], tmp_path / "responses.nc")
    with netcdf_file(str(tmp_path / "responses.nc"), mmap=False) as file:
        assert {"response_real_0", "response_imaginary_0"} <= set(file.variables)


def test_another_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "notes.nc"
    file.write_text("no netCDF")
    with pytest.raises(
        InputError,
        match=r"notes\.nc' cannot be read as frequency responses .*; give a file written by flexros identify frf",
    ):
        load_responses(file)


def test_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the frequency responses cannot be written to .*its folder must exist and be"):
        save_responses([response(4)], tmp_path / "nowhere" / "responses.nc")


def test_folder_instead_of_a_file_is_named() -> None:
    with pytest.raises(
        InputError, match=r"the frequency responses cannot be written to '\.', which is a folder; give a"
    ):
        save_responses([response(4)], Path())


def test_nothing_to_write_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there are no frequency responses to write"):
        save_responses([], tmp_path / "responses.nc")
