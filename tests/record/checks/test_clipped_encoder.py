"""Positions that are cut off or jump."""

from __future__ import annotations

import numpy as np


def test_few_clipped_samples_do_not_count(found, healthy) -> None:
    record = healthy("emps")
    level = float(np.quantile(record.position, 0.98))
    (finding,) = (one for one in found("emps", position=np.minimum(record.position, level)) if one.spoilt is not None)
    assert not finding.hopeless
    assert "stays at the end of its range in" in finding.text
    assert 0.01 * record.n_samples < finding.spoilt.sum() < 0.03 * record.n_samples


def test_mostly_clipped_is_refused(found, healthy) -> None:
    record = healthy("emps")
    level = float(np.quantile(record.position, 0.8))
    finding = found("emps", position=np.minimum(record.position, level))[0]
    assert finding.hopeless
    assert "the encoder or the recorder clips it" in finding.text


def test_encoder_that_wraps_around_is_refused(found, healthy) -> None:
    record = healthy("elbow")
    position = record.position.copy()
    turn = float(np.ptp(position[:, 0])) * 2
    position[10_000:, 0] += turn
    finding = found("elbow", position=position)[0]
    assert finding.hopeless
    assert "the position of motor_1 jumps by" in finding.text
    assert "unwrap it" in finding.text
