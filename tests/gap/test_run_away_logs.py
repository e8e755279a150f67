"""Logs that the model cannot follow at all, as those of an unstable loop, are refused in a sentence."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import place_effects
from flexros.errors import InputError
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.linearisation import linearise
from flexros.gap.measure_gap import measure_gap
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.prepare_fit_data import _check_bounded, fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from flexros.robot import load_robot
from tests import ur5e as example

T = 5e-4
ELBOW = load_robot("elbow")


def swinging_up(largest: float, n: int = 4000) -> Record:
    """A log of motors that swing up until they move by a largest amplitude [rad]."""
    time = np.arange(n) * T
    size = 1e-3 * (largest / 1e-3) ** (time / time[-1])
    phase = 2 * np.pi * 6 * time[:, None] + np.arange(ELBOW.n_motors)
    noise = ELBOW.encoder_noise * np.random.default_rng(1).standard_normal(phase.shape)
    torque = np.clip(20 * size[:, None] * np.sin(phase + 2), -20, 20)
    return Record("bags/wild", T, size[:, None] * np.sin(phase) + noise, torque, np.ones(n, dtype=bool))


def test_a_log_from_which_the_prediction_runs_away_is_refused() -> None:
    with pytest.raises(InputError, match=r"bags/wild: .* 5.05e\+03 rad") as e:
        measure_gap(swinging_up(3500.0), place_effects(ELBOW, ()))
    assert "motors move by up to 5.05e+03 rad or m; check units, signs and order of the motors" in str(e.value)


def test_such_a_log_is_refused_as_holdout_before_the_search() -> None:
    calls: list[str] = []
    with pytest.raises(InputError, match="whether the control loop was stable"):
        diagnose(
            swinging_up(0.1),
            ELBOW,
            holdout=swinging_up(3500.0),
            settings=DiagnosisSettings(where=None),
            progress=lambda stage, share: calls.append(stage),
        )
    assert set(calls) == {"nominal model"}


def test_the_gap_of_a_patch_is_measured_where_the_model_without_it_runs_away() -> None:
    light = place_effects(ELBOW.with_values({"motor_1.inertia": 1e-8, "motor_2.inertia": 1e-8}), ())
    with pytest.raises(InputError, match="the prediction of the nominal model diverges"):
        measure_gap(swinging_up(0.1), light)
    found = measure_gap(swinging_up(0.1), light, repaired=place_effects(ELBOW, ())).numbers
    assert found.after is not None
    assert 1.0 < found.after < 1e9 < found.before


def test_rotors_that_the_robot_file_leaves_out_are_said_to_be_lacking() -> None:
    arm = example.ur5e()
    rotors = {f"{name}.inertia": 0.0 if k in (3, 4) else 0.1 for k, name in enumerate(arm.joint_names)}
    predicted: Any = SimpleNamespace(innovation=np.full((4000, 2, 1), np.nan))
    with pytest.raises(InputError, match="has no rotor inertia at motor_4, motor_5, and the torques do not show it"):
        _check_bounded(predicted, swinging_up(0.1), arm.with_values(rotors))


def test_derivatives_stay_finite_where_a_prediction_runs_away() -> None:
    model = place_effects(ELBOW, ())
    data = fit_data(swinging_up(0.1), model, DiagnosisSettings())
    tolerance = tolerance_of(ELBOW, {"stiffness": 0.01})
    predictor = Predictor(model, (), tolerance, T)
    wild = np.full(len(tolerance.names), 1e9)
    line = linearise(predictor, data, wild)
    assert np.all(np.isfinite(line.information))
    assert line.chi2 == np.inf
    assert np.all(np.isfinite(line.gradient))
