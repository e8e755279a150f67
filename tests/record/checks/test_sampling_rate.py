"""Low rates leave fast effects out of sight."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.mark.parametrize(("every", "told"), [(5, False), (20, True)])
def test_what_a_servo_log_cannot_show_is_told(found, healthy, every: int, told: bool) -> None:
    record = healthy("emps")
    parts = {name: np.ascontiguousarray(getattr(record, name)[::every]) for name in ("position", "torque", "valid")}
    texts = [
        finding.text
        for finding in found("emps", sample_time=record.sample_time * every, velocity=None, noted=None, **parts)
    ]
    assert any("50 samples per second" in text and "25 Hz" in text for text in texts) == told
