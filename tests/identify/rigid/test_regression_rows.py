"""The regression of a log in stretches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.rigid import regression_rows
from flexros.identify.rigid.base_parameters import base_parameters
from flexros.identify.rigid.fit import fit_rigid, rows_of_log
from flexros.identify.rigid.regression_rows import RegressionRows
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.identify.rigid.settings import RigidSettings
from flexros.robot import load_robot

pytestmark = pytest.mark.slow

SLOW = RigidSettings(cutoff=25.0)


@pytest.fixture
def rows(elbow, fourier_motion, rigid_log) -> RegressionRows:
    regressor = RigidRegressor(elbow)
    log = rigid_log(elbow, fourier_motion(12_000, 1e-3, 2), noise=1e-6)
    return rows_of_log(log, SLOW, "log", regressor, base_parameters(regressor, 2))


def test_stretches_are_those_of_the_whole_record(rows: RegressionRows) -> None:
    motion, factor = rows.motion, rows.factor
    whole = rows.regressor.matrix(motion.position, motion.velocity, motion.acceleration, rows.leading)
    H = np.concatenate([block for block, _ in rows.blocks()])
    np.testing.assert_allclose(H, regression_rows.decimate(whole, factor), atol=1e-9)
    assert len(list(rows.blocks())) > 1


def test_triangular_factor_has_the_products_of_all_rows(rows: RegressionRows) -> None:
    other = np.random.default_rng(1).normal(size=rows.torque.shape)
    R = rows.triangular(other)
    H = np.concatenate([block for block, _ in rows.blocks()])
    whole = np.concatenate([H, rows.torque[:, :, None], other[:, :, None]], axis=2)
    for motor in range(2):
        expected = whole[:, motor].T @ whole[:, motor]
        np.testing.assert_allclose(R[:, motor].T @ R[:, motor], expected, atol=1e-9 * np.abs(expected).max())


def test_regressor_that_is_too_large_to_be_kept_gives_the_same_fit(
    elbow, fourier_motion, rigid_log, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = rigid_log(elbow, fourier_motion(12_000, 1e-3, 2), noise=1e-6)
    kept = fit_rigid(log, elbow, SLOW)
    monkeypatch.setattr(regression_rows, "_KEPT_BYTES", 0)
    anew = fit_rigid(log, elbow, SLOW)
    np.testing.assert_array_equal(anew.values, kept.values)
    np.testing.assert_array_equal(anew.covariance, kept.covariance)


def test_error_with_hold_is_that_of_a_fit_with_hold(fourier_motion, rigid_log) -> None:
    robot = load_robot("elbow")
    log = rigid_log(robot, fourier_motion(12_000, 1e-3, 2), noise=1e-6)
    held = fit_rigid(log, robot, SLOW.model_copy(update={"hold": True}))
    assert fit_rigid(log, robot, SLOW).error_with_hold == pytest.approx(held.error.total, rel=0.05)
    assert held.error_with_hold is None


def test_force_error_of_the_values_themselves(elbow, fourier_motion, rigid_log) -> None:
    fit = fit_rigid(rigid_log(elbow, fourier_motion(12_000, 1e-3, 2), noise=1e-3), elbow, SLOW)
    assert fit.force_error(fit.values) == pytest.approx(fit.error.total, rel=1e-9)
    assert fit.force_error(0 * fit.values) == pytest.approx(100)


def test_lost_samples_are_bridged_and_long_gaps_excluded(elbow, fourier_motion, rigid_log) -> None:
    log = rigid_log(elbow, fourier_motion(12_000, 1e-3, 2), noise=1e-6)
    kept = np.delete(np.arange(12_000), [500, 501, 3000, *range(7000, 7100)])
    states = replace(log.joint_states, stamp=log.joint_states.stamp[kept], position=log.joint_states.position[kept])
    whole, lossy = (fit_rigid(each, elbow, SLOW) for each in (log, replace(log, joint_states=states)))
    assert whole.error.rows - 25 < lossy.error.rows < whole.error.rows - 20
    np.testing.assert_allclose(lossy.values, whole.values, atol=1e-3 * np.abs(whole.values).max())
    assert lossy.error.total < 2 * whole.error.total
