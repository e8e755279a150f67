"""Demands that a controller misses."""

from __future__ import annotations

from flexros.benchmark.controllers import BenchmarkController
from flexros.benchmark.demands import LimitCycles, StabilityDemands
from flexros.benchmark.models import ROBOT
from flexros.control.pid import Pid
from flexros.robot import load_robot

GENTLE = Pid(kp=24.0, ki=100.0, kd=2.35, derivative_filter=2.6e-3)


def test_gain_beyond_the_margin_is_unstable_in_a_named_segment() -> None:
    strong = Pid(kp=48.0, ki=200.0, kd=4.7, derivative_filter=2.6e-3)
    found = StabilityDemands(load_robot(ROBOT)).eigenvalues(strong, nominal_only=True)
    assert found["stability, nominal"][0] < 1.0
    value, where = found["stability, loop gain x 2.5"]
    assert value > 1.0
    assert where.startswith("nominal body_1.rz")


def test_c2_has_to_hold_all_sets() -> None:
    stability = StabilityDemands(load_robot(ROBOT))
    of_c1, of_c2 = (stability.eigenvalues(GENTLE, nominal_only=one) for one in (True, False))
    assert set(of_c2) - set(of_c1) == {"stability, M1", "stability, M2"}


def test_limit_cycle_of_an_unstable_loop_is_seen_in_the_run() -> None:
    strong = Pid(kp=24.0, ki=400.0, kd=1.0, derivative_filter=2.6e-3)
    found = {d.name: d for d in LimitCycles(load_robot(ROBOT)).of(BenchmarkController("both", strong, GENTLE))}
    assert not found["limit cycle, loop gain x 2.5, C1"].passed
    assert found["limit cycle, loop gain x 2.5, C1"].value > 0.5
    assert found["limit cycle, loop gain x 2.5, C2"].passed
