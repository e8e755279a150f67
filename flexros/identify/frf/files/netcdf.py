"""Frequency responses in netCDF files, with separate real and imaginary parts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexros.atomic_file import write_result
from flexros.errors import InputError
from flexros.identify.frf.files.labelled import dataset_of, response_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray

    from flexros.identify.frf.frequency_response import FrequencyResponse

SCHEMA = 1
"""Version of the layout of these files."""

_REAL, _IMAG = "_real", "_imaginary"


def save_responses(responses: Sequence[FrequencyResponse], path: Path | str) -> None:
    """Write responses to a netCDF file, whole or not at all.

    Every name in the file ends with the index of the response; attributes of a response are those of its `gears`.

    Args:
        responses: One per position.
        path: The file; an existing one is replaced once the new one is complete.

    Raises:
        InputError: There are no responses, or the file cannot be written.
    """
    import xarray as xr  # deferred: slow to import

    file = Path(path)
    if not responses:
        raise InputError(f"there are no frequency responses to write to '{file}'; estimate at least one")
    parts = [_numbered(_without_complex(dataset_of(response)), number) for number, response in enumerate(responses)]
    whole = xr.merge(parts, combine_attrs="override")
    whole.attrs = {"schema": SCHEMA, "n_responses": len(responses)}
    write_result(file, bytes(whole.to_netcdf(engine="scipy")), "frequency responses")


def load_responses(path: Path | str) -> tuple[FrequencyResponse, ...]:
    """Read the responses that `save_responses` wrote.

    Raises:
        InputError: The file cannot be read, or has other content.
    """
    import xarray as xr  # deferred: slow to import

    file = Path(path)
    try:
        with xr.open_dataset(file, engine="scipy") as opened:
            whole = opened.load()
    except Exception as error:  # damaged files fail in many ways
        reason = (getattr(error, "strerror", None) or "no netCDF 3 file").lower()
        raise InputError(
            f"'{file}' cannot be read as frequency responses ({reason}); give a file written by flexros identify frf"
        ) from error
    if whole.attrs.get("schema") != SCHEMA:
        raise InputError(
            f"'{file}' has schema {whole.attrs.get('schema')}, allowed is {SCHEMA}; give a file written by "
            "flexros identify frf"
        )
    try:
        return tuple(response_of(_with_complex(_single(whole, n))) for n in range(int(whole.attrs["n_responses"])))
    except Exception as error:  # missing parts and wrong shapes fail in many ways
        raise InputError(
            f"'{file}' is damaged ({type(error).__name__}: {error}); give a file written by flexros identify frf"
        ) from error


def _without_complex(dataset: xarray.Dataset) -> xarray.Dataset:
    """Split complex variables into real and imaginary parts."""
    for name in [str(key) for key, values in dataset.data_vars.items() if np.iscomplexobj(values)]:
        values = dataset[name]
        parts = {name + _REAL: values.real, name + _IMAG: values.imag}
        dataset = dataset.drop_vars(name).assign(parts)
        for part in parts:
            dataset[part].attrs = dict(values.attrs)
    return dataset


def _with_complex(dataset: xarray.Dataset) -> xarray.Dataset:
    """Join real and imaginary parts."""
    names = [str(key).removesuffix(_REAL) for key in dataset.data_vars if str(key).endswith(_REAL)]
    for name in names:
        real, imaginary = dataset[name + _REAL], dataset[name + _IMAG]
        dataset = dataset.drop_vars([name + _REAL, name + _IMAG])
        dataset[name] = real + 1j * imaginary
        dataset[name].attrs = dict(real.attrs)
    return dataset


def _numbered(dataset: xarray.Dataset, number: int) -> xarray.Dataset:
    dataset = dataset.rename({name: f"{name}_{number}" for name in {*dataset.variables, *dataset.dims}})
    dataset[f"gears_{number}"].attrs = dict(dataset.attrs)
    return dataset


def _single(whole: xarray.Dataset, number: int) -> xarray.Dataset:
    ending = f"_{number}"
    single = whole[[name for name in whole.data_vars if str(name).endswith(ending)]]
    single = single.rename({name: str(name).removesuffix(ending) for name in {*single.variables, *single.dims}})
    single.attrs = dict(single["gears"].attrs)
    return single
