"""Mapping files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.foreign.mapping import load_mapping, mapping_names

POSITION = {"column": "q", "quantity": "position", "unit": "rad"}


def test_shipped_mappings_load() -> None:
    assert "emps" in mapping_names()
    for name in mapping_names():
        assert load_mapping(name).source


def test_factor_of_a_column_on_the_motor_side(mapping_of) -> None:
    motor = mapping_of(
        {"column": "q", "quantity": "position", "unit": "deg", "gear_ratio": 100, "sign": -1},
        {"column": "u", "quantity": "torque_command", "unit": "mNm", "gear_ratio": 100},
    ).columns
    assert motor[0].factor == pytest.approx(-np.pi / 180 / 100)
    assert motor[1].factor == pytest.approx(0.1)


def test_scale_of_a_unit_without_mechanics(mapping_of) -> None:
    column = mapping_of(
        {"column": "n", "quantity": "position", "unit": "count", "scale": {"value": 2e-3, "unit": "deg/count"}},
        {"column": "v", "quantity": "velocity", "unit": "V", "scale": {"value": 3, "unit": "rad/s/V"}},
    ).columns
    assert column[0].factor == pytest.approx(2e-3 * np.pi / 180)
    assert column[1].factor == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("columns", "keys", "message"),
    [
        ([{**POSITION, "unit": "Nm"}], {}, "column 'q', quantity position: unit 'Nm', but allowed are rad, mrad, deg"),
        ([{**POSITION, "unit": "V"}], {}, "another unit needs a scale, e.g. {value: 2, unit: rad/V}"),
        ([{**POSITION, "unit": "V", "scale": {"value": 1, "unit": "N/V"}}], {}, "unit 'N', but allowed are rad"),
        (
            [{**POSITION, "unit": "V", "scale": {"value": 1, "unit": "rad/A"}}],
            {},
            "unit is 'V', but the scale is per 'A'",
        ),
        ([{**POSITION, "unit": "V", "scale": {"value": 0, "unit": "rad/V"}}], {}, "scale of 0"),
        (
            [{**POSITION, "unit": "V", "scale": {"value": 2, "unit": "rad per V"}}],
            {},
            "scale': unit is 'rad per V', but must be a mechanical unit per unit of the column, as Nm/A",
        ),
        ([{**POSITION, "quantity": "angle"}], {}, "'angle' is not a known quantity; allowed are position, velocity"),
        ([{**POSITION, "joint": "axis1"}], {}, "key 'columns[0].joint' is 'axis1'"),
        ([{**POSITION, "colum": "q"}], {}, "did you mean 'column'?"),
        ([POSITION, POSITION], {}, "position of motor_1 is mapped twice"),
        (
            [POSITION, {"column": "u", "quantity": "torque_command", "unit": "N"}],
            {},
            "motor_1 is rotary by column 'q' but linear by column 'u'",
        ),
        ([{**POSITION, "quantity": "velocity", "unit": "rad/s"}], {}, "the quantity position of motor_1 is missing"),
        ([POSITION], {"time": {"column": "t", "rate": 100}}, "give either 'column' (the name of the time column) or"),
        ([POSITION], {"time": {"column": "t", "unit": "h"}}, "unit is 'h', but allowed are s, ms, us, ns"),
    ],
)
def test_what_is_wrong_is_reported(mapping_of, columns, keys, message: str) -> None:
    with pytest.raises(InputError) as caught:
        mapping_of(*columns, **keys)
    assert message in str(caught.value)
    assert str(caught.value).startswith("mine.yaml: ")


def test_unknown_name() -> None:
    with pytest.raises(InputError, match="unknown mapping 'emp': did you mean 'emps'"):
        load_mapping("emp")


def test_mapping_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("time: {rate: 100}\ncolumns:\n  - {column: q, quantity: position, unit: deg}\n")
    loaded = load_mapping(file)
    assert loaded.name == "mine"
    assert loaded.time.rate == 100
