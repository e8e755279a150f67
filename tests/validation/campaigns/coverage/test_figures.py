"""Counts over repetitions: known shares from normal errors of known size."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.validation.campaigns.coverage.figures import WayCoverage, way_coverage, wilson

NAMES = ("body_1.ry.stiffness", "body_3.ry.stiffness", "body_3.ry.damping")


def coverage(told: float, verdict: str = "determined", groups: int = 50, size: int = 8) -> WayCoverage:
    """Draw errors of 1 % whose standard deviation is said to be `told`."""
    robot, rng = load_robot("e12"), np.random.default_rng(3)
    truth = np.array([robot.parameters[name].value for name in NAMES])

    def row() -> dict[str, Any]:
        return {
            "values": (truth * np.exp(0.01 * rng.standard_normal(3))).tolist(),
            "deviations": [told] * 3,
            "verdicts": ["determined", "determined", verdict],
            "reduced_cost": 1.2,
            "factor": 1.1,
            "converged": bool(rng.uniform() < 0.5),
        }

    return way_coverage("way", [[row() for _ in range(size)] for _ in range(groups)], robot, NAMES)


def test_right_deviations_cover_95_percent() -> None:
    found = coverage(0.01)
    assert found.covered.value == pytest.approx(0.95, abs=0.02)
    assert found.covered.low < found.covered.value < found.covered.high
    assert found.repetitions == 400


def test_deviations_half_as_large_cover_67_percent() -> None:
    assert coverage(0.005).covered.value == pytest.approx(0.673, abs=0.04)


def test_spread_and_bias_are_those_of_the_errors() -> None:
    one = coverage(0.02).parameters[0]
    assert one.spread == pytest.approx(0.01, rel=0.1)
    assert abs(one.bias) < 0.002
    assert one.deviation == 0.02


def test_gear_springs_are_told_from_arm_springs() -> None:
    found = coverage(0.01)
    assert [one.geared for one in found.parameters] == [True, False, False]
    assert found.largest_spring_error(True) == found.parameters[0].largest_error
    assert found.largest_spring_error(False) == found.parameters[1].largest_error


def test_what_is_not_determined_counts_no_error() -> None:
    found = coverage(0.01, verdict="not_determined")
    assert found.parameters[2].largest_error is None
    assert found.parameters[2].verdicts == {"not_determined": 400}
    assert found.most_not_determined == 1


def test_unconverged_fits_are_counted() -> None:
    assert 150 < coverage(0.01).unconverged < 250


@pytest.mark.parametrize(("hits", "low", "high"), [(190, 0.9104, 0.9726), (200, 0.9812, 1.0), (0, 0.0, 0.0188)])
def test_wilson_interval_of_200(hits: int, low: float, high: float) -> None:
    share = wilson(hits, 200)
    assert share.value == hits / 200
    assert (share.low, share.high) == pytest.approx((low, high), abs=1e-4)
