"""The record of a rigid regression."""

from __future__ import annotations

import json

from flexros.identify.rigid.fit import cross_test, fit_rigid
from flexros.identify.rigid.result import result_record
from flexros.identify.rigid.settings import RigidSettings
from flexros.identify.rigid.verdict import judge_fit
from flexros.robot import load_robot


def test_record_of_a_log_in_which_a_motor_rests(fourier_motion, rigid_log) -> None:
    robot = load_robot("e12")
    motion = fourier_motion(8000, 1e-3, 2)
    motion[:, :, 1] = 0
    log = rigid_log(robot, motion, noise=1e-6)
    fit = fit_rigid(log, robot, RigidSettings(cutoff=25.0), "first")
    record = result_record(fit, judge_fit(fit), [cross_test(fit, log, "second")], {"first": {"seed": 1}})
    text = json.loads(json.dumps(record, allow_nan=False))
    assert text["force_error_percent"]["cross_tests"][0]["log"] == "second"
    assert text["excitation"]["motors_that_stood_still"] == ["motor_2"]
    assert not text["excitation"]["rich_enough"]
    assert text["verdict"]["usable"]
    assert text["force_error_percent"]["robot_file"] < 1
    rows = {row["name"]: row for row in text["parameters"]}
    assert rows["motor_2.inertia"]["std"] is None
    assert not rows["motor_2.inertia"]["estimated"]
    assert rows["motor_1.viscous_friction"]["unit"] == "Nm s/rad"
    assert rows["body_1.inertia_at_joint.yy"]["combination"]["motor_1.inertia"] == 1
    assert text["provenance"]["logs"] == {"first": {"seed": 1}}
    assert text["provenance"]["model_hash"] == robot.model_hash
