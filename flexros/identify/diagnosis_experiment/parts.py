"""The parts of a diagnosis experiment; each begins and ends at rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.diagnosis_experiment.vibrations import FADE
from flexros.trajectory import Limits, bang_bang_snap, ninth_degree

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.identify.diagnosis_experiment.sequence import Sequence
    from flexros.identify.diagnosis_experiment.specification import PartName
    from flexros.trajectory.time_law import TimeLaw

SLOWER = 1.0 / 3.0
"""Time of a slower creep relative to the first one; its stroke is shorter [1] (chosen)."""
RAMP = 0.15
"""Acceleration time of a creep as a share of its time in one direction [1] (chosen)."""
RAMP_SHARE = 0.5
"""Largest acceleration of a creep as a share of that of a move [1] (chosen)."""
SIZES = 3
"""Number of sizes of the small slow reversals [1] (chosen)."""
LARGEST = 0.1
"""The largest of them as a share of the stroke of the creep [1] (chosen)."""
SHORTEST_DWELL = 0.2
"""Shortest rest between consecutive moves as a share of the usual one [1] (chosen)."""
STEP_TIMES = (0.03, 0.06, 0.12)
"""Times of the steps [s] (chosen)."""
STEP_SHARE = 0.5
"""Largest acceleration of a step as a share of that of a move [1] (chosen)."""
STEP_REST = 0.15
"""Rest after a step [s] (chosen)."""
PEAK = 10.0
"""Peak acceleration of a step times squared duration over stroke [1], slightly above that of its law."""


def creep(sequence: Sequence, time: float) -> None:
    """Creep in both directions at several speeds: Coulomb and Stribeck friction, orders of the rotor angle.

    Args:
        sequence: Sequence to extend.
        time: Duration [s].
    """
    scales = sequence.vibrations.scales
    speeds = np.array(sequence.specification.creep_speeds) / sequence.specification.creep_speeds[0]
    legs = np.where(speeds < 1.0, SLOWER, 1.0 / np.maximum(speeds, 1.0))
    legs = 0.5 * time * legs / np.sum(legs)
    centre = sequence.current
    for speed, leg in zip(speeds, legs, strict=True):
        law = _steady(leg)
        room = RAMP_SHARE * scales.acceleration / np.max(np.abs(law.evaluate(law.knots, 2)[2]))
        stroke = np.minimum(scales.creep * min(1.0, speed * leg / legs[0]), room)
        stroke = stroke * sequence.random.choice([-1.0, 1.0], len(stroke))
        for goal in (centre + stroke, centre):
            sequence.move(goal, law)


def presliding(sequence: Sequence, time: float) -> None:
    """Reverse slowly with small amplitudes: presliding friction, hysteresis and backlash.

    Args:
        sequence: Sequence to extend.
        time: Duration [s].
    """
    scales = sequence.vibrations.scales
    sizes = np.geomspace(scales.smallest, np.maximum(LARGEST * scales.creep, scales.smallest), SIZES)
    for size in sequence.specification.reversal * sizes:
        duration = sequence.whole(time / SIZES)
        sequence.vibrate(sequence.vibrations.slow(sequence.current, duration, size, sequence.random))


def multisine(sequence: Sequence, time: float) -> None:
    """Vibrate with multisines of rising size, the last one in another pose: how resonances vary with both.

    Args:
        sequence: Sequence to extend.
        time: Duration [s].
    """
    levels = sequence.specification.levels
    for index, level in enumerate(levels):
        if 0 < index == len(levels) - 1:
            sequence.go(sequence.poses[-1])
        _excite(sequence, time / len(levels), level)


def biased(sequence: Sequence, time: float) -> None:
    """Vibrate with a multisine of medium size on a slow swing: backlash vanishes under the load, friction does not.

    Args:
        sequence: Sequence to extend.
        time: Duration [s].
    """
    specification = sequence.specification
    middle = sorted(specification.levels)[len(specification.levels) // 2]
    _excite(sequence, time, middle, specification.bias)


def moves(sequence: Sequence, time: float) -> None:
    """Move fast from pose to pose: inertia, torque gain, saturation, delay.

    Args:
        sequence: Sequence to extend.
        time: Duration [s].
    """
    end = sequence.time + time
    while sequence.time < end:
        sequence.go(sequence.pose(), sequence.random.uniform(SHORTEST_DWELL, 1.0))


def steps(sequence: Sequence, time: float) -> None:
    """Step back and forth within short times: delay, lag, ringing.

    Args:
        sequence: Sequence to extend.
        time: Duration [s].
    """
    end, count, centre = sequence.time + time, 0, sequence.current
    largest = STEP_SHARE * sequence.specification.intensity * sequence.vibrations.scales.acceleration
    while sequence.time < end:
        duration = sequence.whole(STEP_TIMES[count % len(STEP_TIMES)])
        signs = sequence.random.choice([-1.0, 1.0], len(centre))
        for goal in (centre + signs * largest * duration**2 / PEAK, centre):
            sequence.move(goal, ninth_degree(1.0, duration), STEP_REST)
        count += 1


PARTS: Mapping[PartName, Callable[[Sequence, float], None]] = {
    "creep": creep,
    "presliding": presliding,
    "multisine": multisine,
    "biased": biased,
    "moves": moves,
    "steps": steps,
}
"""Function of every part."""


def _steady(time: float) -> TimeLaw:
    """Return a law from 0 to 1 of constant speed apart from its ramps, about as long as a time [s]."""
    ramp = RAMP * time
    rate = 1.0 / (time - ramp)
    return bang_bang_snap(1.0, Limits(rate, 1.5 * rate / ramp, 6.0 * rate / ramp**2, 60.0 * rate / ramp**3))


def _excite(sequence: Sequence, time: float, level: float, bias: float = 0.0) -> None:
    """Vibrate with a multisine, at least for the duration of its fades."""
    specification = sequence.specification
    sequence.vibrate(
        sequence.vibrations.multisine(
            sequence.current,
            max(time, 8.0 * FADE if bias else 4.0 * FADE),
            specification.intensity * level,
            sequence.random,
            (specification.lowest, specification.highest),
            specification.intensity * bias,
        )
    )
