"""Synthetic runs whose errors are known exactly: the circle of the E12 test with a given deviation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.analysis import analyse
from flexros.analysis.comparison import Comparison, MethodRun, QuotedFigure
from flexros.logs.time_series import JointSeries, Log, PoseSeries
from tests.identify.frf.recorded_experiment import run

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray, IntArray

SAMPLE_TIME = 5e-4
RADIUS = 0.025
CENTRE = np.array([2.121403786951, 0.0, -0.354624247994])


def stamps(n: int, sample_time: float = SAMPLE_TIME) -> IntArray:
    return 1_000_000_000 + np.rint(np.arange(n) * sample_time * 1e9).astype(np.int64)


def poses(position: FloatArray, stamp: IntArray | None = None, orientation: FloatArray | None = None) -> PoseSeries:
    n = len(position)
    identity = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    return PoseSeries(
        stamps(n) if stamp is None else stamp, "base", position, identity if orientation is None else orientation
    )


def circle_angle(cycles: int = 1, duration: float = 0.4, rest: float = 0.05) -> FloatArray:
    """Angle along the circle [rad]: a smooth start and stop per cycle, with rest before, between and after."""
    s = np.arange(round(duration / SAMPLE_TIME) + 1) * SAMPLE_TIME / duration
    once = 2 * np.pi * (126 * s**5 - 420 * s**6 + 540 * s**7 - 315 * s**8 + 70 * s**9)
    wait = np.full(round(rest / SAMPLE_TIME), 0.0)
    pieces = [wait]
    for k in range(cycles):
        pieces += [2 * np.pi * k + once, 2 * np.pi * (k + 1) + wait]
    return np.concatenate(pieces)


def circle_points(
    angle: FloatArray, radius: FloatArray | float = RADIUS, other: FloatArray | float | None = None
) -> FloatArray:
    """Points in the x-z plane; with `other` an ellipse of half axes `radius` and `other`."""
    x = radius * np.cos(angle)
    z = (radius if other is None else other) * np.sin(angle)
    return CENTRE + np.column_stack([x, np.zeros_like(x), z])


@dataclass(frozen=True)
class RunMaker:
    """Makes logs of the circle test with a radial deviation [m] that is `error` at its worst."""

    def __call__(
        self, error: float = 3e-4, cycles: int = 1, label: str = "circle", jitter: float = 0.0, feedback: float = 0.1
    ) -> Log:
        angle = circle_angle(cycles)
        n = len(angle)
        rng = np.random.default_rng(7)
        radius = RADIUS + error * np.sin(3 * angle) * np.exp(-0.1 * angle / cycles)
        stamp = stamps(n) + np.rint(rng.normal(0.0, jitter, n) * 1e9).astype(np.int64)
        motor = np.column_stack([0.02 * np.sin(angle), 0.3 + 0.04 * (1 - np.cos(angle))])
        slip = 8e-4 * np.column_stack([np.sin(3 * angle), np.cos(3 * angle) - 1])
        ahead = np.column_stack([2500 * np.sin(angle) * np.cos(angle), -3700 * np.sin(angle)])
        added = feedback * 1000 * np.column_stack([np.sin(5 * angle), np.sin(4 * angle)])
        names = ("motor_1", "motor_2")
        return Log(
            joint_states=JointSeries(stamp, names, position=motor - slip),
            joint_commands=JointSeries(stamp, names, effort=ahead + added),
            joint_reference=JointSeries(
                stamp, names, position=motor, velocity=np.gradient(motor, SAMPLE_TIME, axis=0), effort=ahead
            ),
            tool_pose=poses(circle_points(angle, radius), stamp),
            tool_reference=poses(circle_points(angle), stamp),
            provenance={
                "scenario": label,
                "seed": 1,
                "robot": {"name": "e12", "model_hash": "0f3a9c"},
                "versions": {"flexros": "0.1.0", "numpy": np.__version__},
                "transport": "direct",
            },
        )


@pytest.fixture(scope="session")
def make_run() -> Callable[..., Log]:
    return RunMaker()


@pytest.fixture(scope="session")
def experiment_log() -> Log:
    """A short identification experiment on E12 in two positions with two blocks each."""
    return run().log


@pytest.fixture(scope="module")
def comparison(make_run: Callable[..., Log]) -> Comparison:
    """Two methods, one case that was run twice, one that is only quoted."""

    def run(method: str, case: str, error: float) -> MethodRun:
        return MethodRun(method, case, analyse(make_run(error=error)))

    runs = (
        run("DAE", "nominal", 3e-4),
        run("DAE", "load", 1.2e-3),
        run("DAE", "load", 1.4e-3),
        run("PD", "nominal", 9e-3),
    )
    quoted = (QuotedFigure("DAE", "nominal", 0.32e-3, 0.329e-3), QuotedFigure("DAE", "slow", 0.64e-3, None))
    return Comparison(runs, quoted, ("A caveat.",))
