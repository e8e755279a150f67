"""Disturbances of the benchmark and the windows of its measures (Paper C, section 5.2; times and sizes chosen)."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from flexros.simulate.disturbance import Chirp, Pulse, Step, disturbance_signal, sample_index

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

DURATION = 32.0
"""Length of a run [s]."""

EDGES = (2.0, 6.0, 10.0, 14.0, 18.0, 22.0, 26.0, 29.0, 32.0)
"""Ends of the eight windows of the peak-to-peak deflections [s]."""

STEP_WINDOWS = (0, 1, 4, 5)
"""Windows whose settling time counts: each begins with a step."""

REST = (0.5, 2.0)
"""Time at rest over which the torque caused by noise is measured [s]."""

TOOL_STEP, MOTOR_STEP = 8.0, -6.0
"""Heights of the steps at tool and motor [Nm, motor side]."""

TOOL, MOTOR = "tool.tz", "motor_1"

DISTURBANCES = (
    Step(kind="step", at=TOOL, start=2.0, amplitude=TOOL_STEP),
    Step(kind="step", at=MOTOR, start=6.0, amplitude=MOTOR_STEP),
    Chirp(kind="chirp", at=TOOL, start=10.0, duration=3.5, from_hz=1.0, to_hz=30.0, amplitude=3.0),
    Chirp(kind="chirp", at=MOTOR, start=14.0, duration=3.5, from_hz=1.0, to_hz=30.0, amplitude=2.4),
    Step(kind="step", at=TOOL, start=18.0, amplitude=-TOOL_STEP),
    Step(kind="step", at=MOTOR, start=22.0, amplitude=-MOTOR_STEP),
    Pulse(kind="pulse", at=TOOL, start=26.0, width=0.1, amplitude=4.0),
    Pulse(kind="pulse", at=MOTOR, start=29.0, width=0.1, amplitude=3.0),
)
"""All disturbances, in torque on the motor side of the gear."""


def disturbance_rows(n_samples: int, sample_time: float) -> FloatArray:
    """Return the disturbances at the sampling instants, torque at the motor and wrench at the tool, shape (n, 7)."""
    return disturbance_signal(DISTURBANCES, 1, sample_time, seed=0).rows(0, n_samples)


def static_torque(n_samples: int, sample_time: float) -> FloatArray:
    """Return the torque that holds the steps of the disturbances at rest [Nm], shape (n,)."""
    index = np.arange(n_samples)
    steps = [disturbance for disturbance in DISTURBANCES if isinstance(disturbance, Step)]
    total: FloatArray = -sum((step.values(index, sample_time, 0, 0) for step in steps), start=np.zeros(n_samples))
    return total


def window_rows(sample_time: float) -> tuple[slice, ...]:
    """Return the samples of the eight windows."""
    edges = [sample_index(edge, sample_time) for edge in EDGES]
    return tuple(slice(begin, end) for begin, end in itertools.pairwise(edges))
