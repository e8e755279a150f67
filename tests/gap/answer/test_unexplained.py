"""What a repair leaves of a gap, by joint, part of the motion and frequency band."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

from flexros.gap.answer.unexplained import unexplained
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.errors_ahead import errors_ahead
from tests.gap.diagnosis_logs import MODEL, predictor_of
from tests.gap.sensors.sensor_logs import sensed, sensed_data

if TYPE_CHECKING:
    from flexros.gap.answer.decision import Findings

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("prescribed", [False, True])
def test_shares_of_the_bands_add_up_also_where_only_a_sensor_shows_the_rest(prescribed: bool) -> None:
    data = sensed_data(sensed("stiffness_error@body_1.rz:relative=0.02", sensors=("link position",)))
    nominal = CandidateFit(predictor_of(), np.zeros(0), 0.0)
    errors = errors_ahead(nominal, data)
    if prescribed:  # the motion of the motor, whose position is then no signal
        errors = replace(errors, squares=errors.squares[:, 1:], floor=errors.floor[1:], prescribed=(0,))
    findings = cast("Findings", SimpleNamespace(model=MODEL, held=data, repaired=nominal))
    rows = unexplained(findings, errors, errors)
    assert rows
    for row in rows:
        shares = [band.share for band in row.bands]
        assert sum(shares) == pytest.approx(row.share)
        assert (np.ptp(shares) < 1e-9) == prescribed
