"""The record of an identified axis."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.axis import OneAxisIdentification, identify_one_axis
from flexros.identify.axis.resonances import Resonances
from flexros.identify.axis.result import result_record
from flexros.robot import load_robot
from tests.identify.axis.recorded_axis import recorded_axis

pytestmark = pytest.mark.slow

RESONANCES = Resonances((15.9,), (25.2,), "command line")


@pytest.fixture(scope="module", name="identification")
def fixture_identification() -> OneAxisIdentification:
    log = recorded_axis(samples=2100)
    return identify_one_axis(
        log, load_robot("two_mass"), antiresonances=RESONANCES.antiresonances, resonances=RESONANCES.resonances
    )


def test_record_holds_values_intervals_and_gain(identification: OneAxisIdentification) -> None:
    identification = replace(identification, warnings=("it rained",))
    record = result_record(identification, "motor_1", RESONANCES, {"log": {"seed": 1}})
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    row = next(row for row in record["nonlinear"]["parameters"] if row["name"] == "gear_knee")
    assert (row["unit"], row["value"]) == ("rad", identification.nonlinear.parameters["gear_knee"])
    assert row["interval"][0] < 0.003 < row["interval"][1]
    assert "gear_knee" not in {row["name"] for row in record["linear"]["parameters"]}
    assert (record["gain"], record["gain_on"]) == (identification.gain, "fit")
    assert record["nonlinear"]["validation"] is None
    assert record["warnings"][0] == "it rained"
    assert record["provenance"]["logs"] == {"log": {"seed": 1}}


def test_value_that_is_not_identifiable_has_no_interval_and_is_warned_of(identification: OneAxisIdentification) -> None:
    covariance = identification.nonlinear.covariance.copy()
    place = identification.nonlinear.structure.names.index("viscous_friction")
    covariance[place, place] = np.inf
    unknown = replace(
        identification,
        nonlinear=replace(identification.nonlinear, covariance=covariance, whiteness=0.8, converged=False),
    )
    record = result_record(replace(unknown, warnings=()), "motor_1", RESONANCES, {})
    row = next(row for row in record["nonlinear"]["parameters"] if row["name"] == "viscous_friction")
    assert (row["std"], row["interval"]) == (None, None)
    assert [text.split(",")[0].split(":")[0].split(";")[0] for text in record["warnings"]] == [
        "the search did not converge",
        "neighbouring prediction errors are correlated by 0.80",
        "the log hardly determines viscous_friction",
    ]
