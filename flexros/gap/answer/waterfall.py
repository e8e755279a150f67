"""The gap of held-out data from the nominal model to the repaired one, an effect at a time."""

from __future__ import annotations

from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.answer.decision import effect_location
from flexros.gap.schema import Step, Waterfall

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.answer.partial_repairs import PartialRepairs


def waterfalls(repairs: PartialRepairs) -> tuple[Waterfall, ...]:
    """Divide the gap at each joint among the effects, added one after the other.

    First comes what closes most: on the mean of added first and removed last, the effect on which the two agree or
    that leads in either. The steps add up to what is closed; where effects overlap, the first one takes what both do.

    Args:
        repairs: Prediction errors with a part of the effects.
    """
    joints = repairs.findings.model.robot.joint_names
    before, left = repairs.by_joint(repairs.before), repairs.by_joint(repairs.after)
    steps = _steps(repairs)
    return tuple(
        Waterfall(
            joint=joint,
            before=float(before[motor]),
            steps=tuple(
                Step(effect=located.effect, location=located.location, share=float(closed[motor]))
                for located, closed in ((effect_location(name), closed) for name, closed in steps.items())
            ),
            left=float(left[motor]),
        )
        for motor, joint in enumerate(joints)
    )


def _steps(repairs: PartialRepairs) -> dict[str, FloatArray]:
    """Return what each effect closes at each joint [1], by effect@location, in their order."""
    names, kept = repairs.names, repairs.kept
    divided = sorted(names - kept)
    repairs.prepare([*(kept | {name} for name in divided), *(names - {name} for name in divided)])
    both = {name: repairs.closed_by(kept | {name}) - repairs.closed_by(names - {name}) for name in divided}
    order = sorted(both, key=lambda name: -both[name])
    parts = list(accumulate(order, lambda part, name: part | {name}, initial=kept))
    repairs.prepare(parts[1:])
    levels = [repairs.by_joint(errors) for errors in (repairs.before, *(repairs.errors(part) for part in parts[1:]))]
    steps = {name: high - low for name, (high, low) in zip(order, pairwise(levels), strict=True)}
    rounding = levels[-1] - repairs.by_joint(repairs.after)
    for name, quantization in repairs.findings.quantized.items():
        steps[name] = np.where(np.arange(len(rounding)) == quantization.motor, rounding, 0.0)
    return steps
