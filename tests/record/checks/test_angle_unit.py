"""Positions in degrees that were taken as radians, on an arm with weight."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.checks.angle_unit import MOST

pytestmark = pytest.mark.slow


def test_degrees_are_named_where_weight_hides_the_factor(found, healthy) -> None:
    record = healthy("elbow")
    findings = found("elbow", position=np.degrees(record.position))
    assert findings[0].hopeless
    assert any("give 'unit: deg'" in finding.text for finding in findings)


def test_a_joint_that_turns_far_is_no_mistake(found, healthy) -> None:
    """A wrist or a wheel turns many times: the torques fit as they are."""
    turned = healthy("two_mass").position + 2 * MOST
    assert not any("deg" in finding.text for finding in found("two_mass", position=turned))
