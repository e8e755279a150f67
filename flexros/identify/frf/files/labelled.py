"""Frequency responses as labelled arrays (xarray) and back, without loss."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.distortion import Distortion
from flexros.identify.frf.frequency_response import FrequencyResponse

if TYPE_CHECKING:
    import pandas as pd
    import xarray

SEPARATOR = ";"
"""Separator of the sentences and units in text attributes."""

_ERRORS = ("noise_error", "total_error")


def dataset_of(response: FrequencyResponse) -> xarray.Dataset:
    """Convert a frequency response to labelled arrays.

    Returns:
        Variables response (frequency, output, input), noise_error and total_error (frequency, output, output_2),
        input_inverse (frequency, input, input_2), standard deviations, gears and motor_position (motor), and the
        distortion levels as distortion_*; units in the attributes.
    """
    import xarray as xr  # deferred: slow to import

    units = {
        "input_units": SEPARATOR.join(response.input_units),
        "coordinate_units": SEPARATOR.join(response.coordinate_units),
        "output_units": SEPARATOR.join(response.output_units),
    }
    variables: dict[str, object] = {
        "response": (("frequency", "output", "input"), response.response, units),
        "input_inverse": (("frequency", "input", "input_2"), response.input_inverse),
        "gears": (("motor",), response.gears),
        "motor_position": (("motor",), response.motor_position),
    }
    for name in _ERRORS:
        error = getattr(response, name)
        if error is not None:
            kind = name.split("_")[0]
            variables[name] = (("frequency", "output", "output_2"), error)
            deviation = response.standard_deviation(kind)  # type: ignore[arg-type]
            variables[f"{kind}_standard_deviation"] = (("frequency", "output", "input"), deviation)
    coordinates: dict[str, object] = {
        "frequency": (("frequency",), response.frequency, {"units": "Hz"}),
        "output": list(response.output_names),
        "output_2": list(response.output_names),
        "input": list(response.input_names),
        "input_2": list(response.input_names),
    }
    if response.distortion is not None:
        variables |= _distortion_variables(response.distortion, coordinates)
    attributes = {
        "quantity": response.quantity,
        "sample_time": response.sample_time,
        "n_periods": response.n_periods,
        "n_blocks": response.n_blocks,
        "degrees_of_freedom": response.degrees_of_freedom,
        "warnings": "\n".join(response.warnings),
    }
    return xr.Dataset(variables, coordinates, attributes)


def frame_of(response: FrequencyResponse) -> pd.DataFrame:
    """Convert a frequency response to a table with a row for each line, output and input.

    Returns:
        Columns response (complex), magnitude, phase_deg (of the principal value) and std, by frequency [Hz], output
        and input; std is NaN where the record does not determine it.
    """
    import pandas as pd  # deferred: slow to import

    levels = (response.frequency, list(response.output_names), list(response.input_names))
    index = pd.MultiIndex.from_product(levels, names=["frequency", "output", "input"])
    values = response.response.reshape(-1)
    kind = "total" if response.total_error is not None else "noise"
    known = response.total_error is not None or response.noise_error is not None
    deviation = response.standard_deviation(kind).reshape(-1) if known else np.full(len(values), np.nan)  # type: ignore[arg-type]
    columns = {
        "response": values,
        "magnitude": np.abs(values),
        "phase_deg": np.degrees(np.angle(values)),
        "std": deviation,
    }
    return pd.DataFrame(columns, index=index)


def _distortion_variables(distortion: Distortion, coordinates: dict[str, object]) -> dict[str, object]:
    """Label the levels; each kind of line has its own frequency axis."""
    variables: dict[str, object] = {}
    for field in fields(distortion):
        kind = field.name.split("_")[0]
        axis = f"{kind}_frequency" if kind in ("odd", "even") else "frequency"
        value = getattr(distortion, field.name)
        if field.name == axis:
            coordinates[axis] = ((axis,), value, {"units": "Hz"})
        else:
            variables[f"distortion_{field.name}"] = ((axis, "output"), value)
    return variables


def response_of(dataset: xarray.Dataset) -> FrequencyResponse:
    """Rebuild the frequency response from its labelled arrays, the inverse of `dataset_of`."""
    attributes = dataset.attrs
    text = str(attributes.get("warnings", ""))  # netCDF drops empty attributes
    units = dataset["response"].attrs
    return FrequencyResponse(
        frequency=dataset["frequency"].to_numpy(),
        response=dataset["response"].to_numpy(),
        noise_error=dataset["noise_error"].to_numpy() if "noise_error" in dataset else None,
        total_error=dataset["total_error"].to_numpy() if "total_error" in dataset else None,
        input_inverse=dataset["input_inverse"].to_numpy(),
        degrees_of_freedom=float(attributes["degrees_of_freedom"]),
        input_names=tuple(str(name) for name in dataset["input"].to_numpy()),
        output_names=tuple(str(name) for name in dataset["output"].to_numpy()),
        input_units=tuple(str(units["input_units"]).split(SEPARATOR)),
        coordinate_units=tuple(str(units["coordinate_units"]).split(SEPARATOR)),
        gears=dataset["gears"].to_numpy(),
        motor_position=dataset["motor_position"].to_numpy(),
        sample_time=float(attributes["sample_time"]),
        n_periods=int(attributes["n_periods"]),
        n_blocks=int(attributes["n_blocks"]),
        quantity=attributes["quantity"],
        distortion=_distortion_of(dataset),
        warnings=tuple(text.split("\n")) if text else (),
    )


def _distortion_of(dataset: xarray.Dataset) -> Distortion | None:
    if "distortion_output" not in dataset:
        return None
    values = {}
    for field in fields(Distortion):
        name = field.name if field.name.endswith("frequency") else f"distortion_{field.name}"
        values[field.name] = np.asarray(dataset[name].to_numpy())
    return Distortion(**values)
