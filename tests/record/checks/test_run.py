"""Records that are checked after reading."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.record.checks.run import check_record


def test_hopeless_record_is_refused_by_name(healthy, robots) -> None:
    record = replace(healthy("emps").part(0, 800), name="cut")
    with pytest.raises(InputError, match=r"^cut: the log is too short: it has 0\.8 s"):
        check_record(record, robots("emps"))


def test_refusal_says_what_reading_found(healthy, robots) -> None:
    """A log may be too short because its end is lost."""
    cut = replace(healthy("emps").part(0, 800), name="cut", warnings=("it is truncated at byte 700",))
    with pytest.raises(InputError, match=r"too short.*\(in reading it: it is truncated at byte 700\)$"):
        check_record(cut, robots("emps"))


def test_record_that_overlaps_its_commands_for_some_samples_only_is_too_short(healthy, robots) -> None:
    with pytest.raises(InputError, match="too short: it has 0.01 s with 10 measured samples"):
        check_record(healthy("emps").part(0, 10), robots("emps"))


@pytest.mark.slow
def test_wrong_parameters_are_no_reason_to_refuse_an_identification(healthy, robots) -> None:
    """A mass that is four times the nominal one looks like a wrong unit."""
    record = healthy("emps")
    heavy = replace(record, torque=4.0 * record.torque)
    with pytest.raises(InputError, match="a multiple of what robot emps needs"):
        check_record(heavy, robots("emps"))
    checked = check_record(heavy, robots("emps"), parameters_known=False)
    assert any("a multiple of what robot emps needs" in text for text in checked.warnings)


def test_inverted_sign_is_refused_in_an_identification_too(healthy, robots) -> None:
    record = healthy("emps")
    with pytest.raises(InputError, match="inverted"):
        check_record(replace(record, torque=-record.torque), robots("emps"), parameters_known=False)


@pytest.mark.slow
def test_spoilt_samples_are_not_valid(healthy, robots) -> None:
    record = healthy("emps")
    position = np.array(record.position)
    position[2000:2020] = position[2000]
    checked = check_record(replace(record, position=position), robots("emps"))
    assert not checked.valid[2001:2020].any()
    assert checked.valid[:2000].all()


@pytest.mark.slow
def test_what_doubts_the_model_is_told_apart_from_what_doubts_the_log(healthy, robots) -> None:
    record = replace(healthy("elbow"), warnings=("of the recorder",))
    checked = check_record(record, robots("e12"), parameters_known=False)
    (doubt,) = checked.doubts
    assert "what the bodies of robot e12 need for this motion" in doubt
    assert doubt in checked.warnings
    assert checked.without_warnings(checked.doubts).warnings == ("of the recorder",)
