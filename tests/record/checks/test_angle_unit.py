"""Positions in degrees that were taken as radians, on an arm with weight."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.checks import unit
from flexros.record.checks.degrees import MOST
from flexros.record.checks.unit import Unit

pytestmark = pytest.mark.slow


def test_degrees_are_named_where_weight_hides_the_factor(found, healthy, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Unit, "look", lambda *_: ())  # as on an arm of six axes, whose weight turns round many times
    findings = found("elbow", position=np.degrees(healthy("elbow").position))
    assert findings[0].hopeless
    assert "give 'unit: deg'" in findings[0].text


def test_a_joint_that_turns_far_is_no_mistake(found, healthy) -> None:
    """A wrist or a wheel turns many times: the torques fit as they are."""
    turned = healthy("two_mass").position + 2 * MOST
    assert not any("deg" in finding.text for finding in found("two_mass", position=turned))


def test_degrees_are_named_where_the_factors_of_motors_have_no_cause_in_common(
    found, healthy, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction and weight move the factors: on a UR5 they were 0.015 and 0.025, which looked like no known mistake."""
    monkeypatch.setattr(unit, "_common_causes", lambda *_: [])
    findings = found("elbow", position=np.degrees(healthy("elbow").position))
    assert findings[0].hopeless
    assert "give 'unit: deg'" in findings[0].text
