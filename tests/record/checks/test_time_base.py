"""Stamps with another rate than the samples."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("robot", ["four_mass_linear", "emps"])
@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_wrong_rate_is_named(found, healthy, robot: str, factor: float) -> None:
    T = healthy(robot).sample_time
    findings = found(robot, sample_time=factor * T)
    assert findings[0].hopeless
    assert (
        f"the stamps are {1e3 * factor * T:.6g} ms apart, but torques and motions fit robot {robot} far better at its "
        f"sample time of {1e3 * T:.6g} ms: the time base of the log is wrong"
    ) in findings[0].text


def test_log_of_a_lower_rate_is_no_problem(found, healthy) -> None:
    from dataclasses import replace

    record = healthy("elbow")
    torque = record.torque[: record.n_samples // 2 * 2].reshape(-1, 2, 2).mean(axis=1)
    slower = replace(
        record,
        sample_time=2 * record.sample_time,
        position=record.position[: len(torque) * 2 : 2],
        torque=torque,
        noted=None,
        valid=record.valid[: len(torque) * 2 : 2],
        reference=None,
        tool=None,
    )
    assert [finding.text for finding in found("elbow", slower)] == []
