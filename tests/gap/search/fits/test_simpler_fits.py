"""Fits with fewer parameters: what ended at a limit of its search is no finding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.checked_log import checked_log
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import search_of, settings_of
from tests.gap.servo_logs import servo_log, servo_robot

pytestmark = pytest.mark.slow


def test_a_raised_gain_of_a_servo_goes_before_the_friction_that_it_took_to_its_limit() -> None:
    """Positions determine gain, friction and inertia up to a factor, which runs until one of them is at its limit."""
    record = checked_log(servo_log("coulomb_friction@motor_1:level=0.25"), servo_robot(), name="log")
    model = RobotWithEffects(servo_robot(), ()).commanded_by(record.commands)
    search = prepare_search(fit_null(fit_data(record, model, DiagnosisSettings()), model, Tolerance()), settings_of())
    among = {one.name: one for one in search.candidates()}
    friction, gain = among["coulomb_friction@motor_1"], among["servo_stiffness_error@motor_1"]
    narrow = replace(friction, free=(replace(friction.free[0], high=0.4),))
    predictor = search.null.predictor((narrow, gain))
    theta = np.array([narrow.free[0].encode(0.4), gain.free[0].encode(0.6)])
    found = search.within_limits(CandidateFit(predictor, theta, chi2_of(predictor, search.data, theta[:, None])[0]))
    assert found.names == {friction.name}
    assert found.predictor.values(found.theta)[0]["level"] == pytest.approx(0.25, rel=0.05)


def test_a_hump_whose_shape_ended_at_a_limit_is_begun_anew() -> None:
    truth = {"extra": 0.1, "velocity": 0.02, "exponent": 2.0}
    stated = ",".join(f"{name}={value}" for name, value in truth.items())
    search = search_of(f"stribeck_friction@motor_1:{stated}")
    (hump,) = (one for one in search.candidates() if one.name == "stribeck_friction@motor_1")
    theta = np.array([free.encode({**truth, "velocity": 0.03, "exponent": free.high}[free.name]) for free in hump.free])
    predictor = search.null.predictor((hump,))
    limited = CandidateFit(predictor, theta, chi2_of(predictor, search.data, theta[:, None])[0])
    found = search.within_limits(limited)
    assert found.predictor.values(found.theta)[0] == pytest.approx(truth, rel=0.1)
    spoiled = replace(limited, chi2=0.0)
    assert {free.name for free in search.within_limits(spoiled).hypothesis[0].free} == {"extra", "velocity"}
