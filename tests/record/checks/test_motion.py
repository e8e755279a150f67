"""Without motion there is nothing to be predicted."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flexros.record.checks.motion import Motion


def test_log_without_motion_is_refused(found, healthy) -> None:
    record = healthy("e12")
    noise = 2e-6 * np.random.default_rng(1).normal(size=record.position.shape)
    finding = found("e12", position=record.position[0] + noise)[0]
    assert finding.hopeless
    assert "no motor moves beyond the noise of its encoder, so there is no excitation" in finding.text


@pytest.mark.slow
def test_motor_that_stands_still_is_told(found, healthy) -> None:
    record = healthy("e12")
    position = record.position.copy()
    position[:, 1] = position[0, 1] + 2e-6 * np.random.default_rng(1).normal(size=len(position))
    texts = [finding.text for finding in found("e12", position=position)]
    assert any("motor_2 does not move beyond the noise of its encoder" in text for text in texts)


def test_motors_that_stand_still_are_told_together() -> None:
    """Without those that are prescribed or never change at all, of which other lines tell."""
    time = np.arange(1000.0)
    position = np.column_stack([np.sin(time), time % 3, time % 2, time % 5, 0 * time])
    record = SimpleNamespace(position=position, valid=np.ones(1000, dtype=bool), prescribed=(3,))
    robot = SimpleNamespace(joint_names=[f"motor_{k}" for k in range(1, 6)])
    moves = np.array([True, False, False, False, False])
    checked = SimpleNamespace(record=record, robot=robot, moves=moves, motion=(position, position))
    (finding,) = Motion().look(checked)
    assert finding.text == (
        "motor_2, motor_3 do not move beyond the noise of their encoders, so little about them is identifiable"
    )


def test_short_motion_is_refused(found, healthy) -> None:
    record = healthy("emps")
    time = np.arange(record.n_samples)
    step = 0.01 / (1 + np.exp(-(time - 5000) / 8.0))
    noise = 1e-6 * np.random.default_rng(1).normal(size=len(time))
    finding = found("emps", position=(step + noise)[:, None])[0]
    assert finding.hopeless
    assert "samples only, at least 200 are needed" in finding.text
