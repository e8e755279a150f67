"""Errors of settings as sentences."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import pytest
from pydantic import Field

from flexros.config.settings import Settings, validate
from flexros.errors import InputError


class Square(Settings):
    type: Literal["square"]
    side: float = Field(gt=0)


class Disc(Settings):
    type: Literal["disc"]
    radius: float


class Drawing(Settings):
    title: str
    shapes: tuple[Annotated[Square | Disc, Field(discriminator="type")], ...] = ()
    scale: float | None = None


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({}, "a.yaml: key 'title' is missing; add it"),
        (
            {"title": "t", "scal": 1},
            "a.yaml: unknown key 'scal': did you mean 'scale'? allowed are title, shapes, scale",
        ),
        ({"titel": "t"}, "a.yaml: unknown key 'titel': did you mean 'title'?"),
        ({"title": 3}, "a.yaml: key 'title' is 3, but input should be a valid string; correct the value"),
        (
            {"title": "t", "shapes": [{"type": "square", "side": -1}]},
            "a.yaml: key 'shapes[0].side' is -1, but input should be greater than 0; correct the value",
        ),
        (
            {"title": "t", "shapes": [{"type": "disc", "radius": 1, "radios": 2}]},
            "a.yaml: unknown key 'shapes[0].radios': did you mean 'radius'? allowed are type, radius",
        ),
        ({"title": "t", "shapes": [{"type": "disc"}]}, "a.yaml: key 'shapes[0].radius' is missing; add it"),
        ({"title": "t", "scale": float("nan")}, "a.yaml: key 'scale' is nan, but input should be a finite number"),
    ],
)
def test_first_problem_as_one_sentence(data: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        validate(Drawing, data, "a.yaml")
    assert str(caught.value).startswith(message)


def test_valid_data_becomes_an_object() -> None:
    drawing = validate(Drawing, {"title": "t", "shapes": [{"type": "disc", "radius": 2}]}, "a.yaml")
    assert drawing.shapes == (Disc(type="disc", radius=2),)


class Number(Settings):
    value: float
    tolerance: float = 0.0


class Plate(Settings):
    title: str
    width: Number | None = None


def test_a_key_that_a_number_has_is_shown_where_it_belongs() -> None:
    """A user wrote the tolerance of a spring beside its stiffness, and was told the keys that are allowed there."""
    with pytest.raises(
        InputError, match=r"'tolerance': that of a number is written width: \{value: ..., tolerance: 0.2\}"
    ):
        validate(Plate, {"title": "t", "tolerance": 0.2}, "a.yaml")
