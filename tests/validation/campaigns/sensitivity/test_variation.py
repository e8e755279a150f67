"""Variations of the numbers of any settings model."""

from __future__ import annotations

import pytest
from pydantic import Field

from flexros.config.settings import Settings
from flexros.errors import InputError
from flexros.gap.settings import DiagnosisSettings
from flexros.validation.campaigns.sensitivity.settings import NOT_VARIED
from flexros.validation.campaigns.sensitivity.variation import numeric_keys, varied


class Inner(Settings):
    share: float = Field(default=0.4, lt=1)
    bands: tuple[float, ...] = (1.0, 10.0)
    words: tuple[str, ...] = ("a",)


class Outer(Settings):
    inner: Inner = Inner()
    starts: int = 3
    switch: bool = True
    none: float = 0.0
    seed: int = 7


def test_numbers_of_groups_are_found_by_dotted_names() -> None:
    assert numeric_keys(Outer(), ("seed",)) == {"inner.share": 0.4, "inner.bands": (1.0, 10.0), "starts": 3}


@pytest.mark.parametrize(
    ("key", "factor", "changed"),
    [
        ("inner.share", 2.0, Outer(inner=Inner(share=0.8))),
        ("inner.bands", 0.5, Outer(inner=Inner(bands=(0.5, 5.0)))),
        ("starts", 0.5, Outer(starts=2)),
        ("starts", 2.0, Outer(starts=6)),
    ],
)
def test_one_setting_is_multiplied(key: str, factor: float, changed: Outer) -> None:
    assert varied(Outer(), key, factor) == changed


def test_a_value_that_is_not_allowed_is_refused() -> None:
    with pytest.raises(InputError, match=r"inner\.share times 4: key 'inner\.share' is 1\.6"):
        varied(Outer(), "inner.share", 4.0)


def test_settings_of_the_diagnosis_are_varied_but_for_resources() -> None:
    keys = numeric_keys(DiagnosisSettings(), NOT_VARIED)
    assert keys
    assert not {key.partition(".")[0] for key in keys} & set(NOT_VARIED)
    assert set(NOT_VARIED) <= set(DiagnosisSettings.model_fields)
