"""The verdict on a fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.rigid.fit import LARGEST_ERROR, fit_rigid
from flexros.identify.rigid.settings import RigidSettings
from flexros.identify.rigid.verdict import judge_fit

pytestmark = pytest.mark.slow

SLOW = RigidSettings(cutoff=25.0)


def test_good_fit_gets_a_robot(elbow, fourier_motion, rigid_log) -> None:
    verdict = judge_fit(fit_rigid(rigid_log(elbow, fourier_motion(8000, 1e-3, 2), noise=1e-6), elbow, SLOW))
    assert verdict.usable
    assert verdict.sentence.endswith("% of the torque unexplained")
    assert verdict.identified.values
    assert verdict.file_error is not None
    assert verdict.file_error < 0.1


@pytest.mark.parametrize(
    ("robot", "advice"),
    [("elbow", "the motion excites the flexibilities or shows too little; record slow moves"), ("emps", "check robot")],
)
def test_torque_that_the_model_does_not_explain(request, fourier_motion, rigid_log, robot: str, advice: str) -> None:
    machine = request.getfixturevalue(robot)
    log = rigid_log(machine, fourier_motion(8000, 1e-3, machine.n_motors))
    torque = log.joint_commands.effort
    time = np.arange(8000)[:, None] * 1e-3
    torque += 0.6 * np.std(torque, axis=0) * np.sin(2 * np.pi * 9 * time)
    verdict = judge_fit(fit_rigid(log, machine, SLOW))
    assert not verdict.usable
    assert "% of the torque unexplained, more than 20 %: " in verdict.sentence
    assert advice in verdict.sentence
    assert not verdict.identified.values
    assert verdict.file_error is None


def test_hold_is_advised_where_it_helps(elbow, fourier_motion, rigid_log) -> None:
    fit = fit_rigid(rigid_log(elbow, fourier_motion(8000, 1e-3, 2)), elbow, SLOW)
    poor = replace(fit, error=replace(fit.error, total=30.0), error_with_hold=5.0)
    assert judge_fit(poor).sentence.endswith(
        "with delay and hold of the command it would be 5 %; pair positions with the command as it acts (setting hold)"
    )


def test_values_that_no_robot_can_have(emps, fourier_motion, rigid_log) -> None:
    fit = fit_rigid(rigid_log(emps, fourier_motion(8000, 1e-3, 1)), emps, SLOW)
    values = fit.values.copy()
    values[fit.base.names.index("body_1.mass")] = -500.0
    verdict = judge_fit(replace(fit, values=values))
    assert "body_1" in verdict.identified.left_out
    assert list(verdict.identified.not_met) == ["body_1.mass"]
    assert verdict.usable  # the nominal mass explains the torque just as well
    assert verdict.sentence.endswith("%, since not all identified values are feasible")


def test_values_most_of_which_no_robot_can_have(elbow, fourier_motion, rigid_log) -> None:
    fit = fit_rigid(rigid_log(elbow, fourier_motion(8000, 1e-3, 2)), elbow, SLOW)
    names = zip(fit.base.units, fit.base.names, strict=True)
    inertial = [unit.startswith("kg") or "viscous" in name for unit, name in names]
    verdict = judge_fit(replace(fit, values=np.where(inertial, -5000.0, fit.values)))
    assert not verdict.usable
    assert verdict.file_error is not None
    assert verdict.file_error < 20  # the nominal robot, which is the real one here
    assert "with infeasible values (the nearest feasible robot misses 9 of 13 and leaves 0.0" in verdict.sentence


def test_a_lower_cutoff_is_advised_where_the_noise_of_a_coarse_encoder_is_fast(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(8000, 1e-3, 1), noise=2e-4)
    fit = fit_rigid(log, emps)
    assert fit.error.total > LARGEST_ERROR
    assert fit.other_cutoff is not None
    cutoff, error = fit.other_cutoff
    assert error < LARGEST_ERROR
    assert fit_rigid(log, emps, RigidSettings(cutoff=cutoff)).error.total == pytest.approx(error)
    assert f"with a cut-off of {cutoff:.3g} Hz instead of 100 Hz it would be {error:.3g} %" in judge_fit(fit).sentence
    assert fit_rigid(log, emps, RigidSettings(cutoff=100.0)).other_cutoff is None  # as the user wants it


def test_a_higher_cutoff_is_advised_where_the_motors_move_faster(emps, rigid_log) -> None:
    """As a motor without load does: what is slow is mostly torque that the model lacks."""
    time, w = 0.002 * np.arange(8000)[:, None], 2 * np.pi * np.array([27.0, 31.0, 0.5])
    size = np.array([1.0, 0.7, 3.0]) * 1e-3
    motion = np.array(
        [
            (size * np.sin(w * time)).sum(axis=1, keepdims=True),
            (size * w * np.cos(w * time)).sum(axis=1, keepdims=True),
            (-size * w**2 * np.sin(w * time)).sum(axis=1, keepdims=True),
        ]
    )
    log = rigid_log(emps, motion, 0.002, friction=lambda _: 300 * np.sin(2 * np.pi * 0.3 * time))
    fit = fit_rigid(log, emps)
    assert fit.error.total > LARGEST_ERROR
    assert fit.other_cutoff is not None
    assert fit.other_cutoff[0] == pytest.approx(100.0)
    said = judge_fit(fit).sentence
    assert f"it would be {fit.other_cutoff[1]:.3g} %: the motors move faster than that (setting cutoff)" in said
