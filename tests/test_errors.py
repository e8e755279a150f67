from __future__ import annotations

import pytest

from flexros.errors import InputError, RunError, source_named, unknown_name


def test_source_prefixes_the_text_of_an_input_error():
    with (
        pytest.raises(InputError, match=r"^file x.yaml, key mass: is negative$"),
        source_named("file x.yaml, key mass"),
    ):
        raise InputError("is negative")


def test_other_errors_keep_their_text():
    with pytest.raises(RunError, match=r"^aborted$"), source_named("file x.yaml"):
        raise RunError("aborted")


def test_an_unknown_name_offers_the_nearest():
    error = unknown_name("robot", "e21", ["e12", "emps"], "--model")
    assert str(error) == "unknown robot 'e21' in --model: did you mean 'e12'? allowed are e12, emps"


def test_of_many_names_the_nearest_five_are_listed():
    names = [f"body_{number}.mass" for number in range(1, 22)]
    text = str(unknown_name("parameter", "body_3.mas", names, "--unknown", "(others are named alike)"))
    assert text.startswith(
        "unknown parameter 'body_3.mas' in --unknown: did you mean 'body_3.mass'? the nearest of 21 "
    )
    assert text.count("body_") == 7
    assert text.endswith("(others are named alike)")
    assert "the nearest of" not in str(unknown_name("parameter", "body_3.mas", names[:20]))


def test_a_source_is_named_once() -> None:
    with pytest.raises(InputError) as caught, source_named("scenario a"), source_named("scenario a"):
        raise InputError("x is 3")
    assert str(caught.value) == "scenario a: x is 3"
