"""Torques that an answer leaves, where errors of predicted positions do not show them.

Of a motor that turns hardly any inertia, as where the rotor is not known, a torque within the tolerance moves it by so
much that its positions are not predicted at all: an unknown cable at a wrist made its whole torque, and every
prediction was within noise and tolerance. A rotor that is far too large hides torques too, as they hardly move it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.answer.decision import Findings

MOST = 0.4
"""Share of what changes of a torque that an answer may usually leave to be `explained` [1] (chosen)."""


def unexplained_torques(findings: Findings) -> dict[str, float]:
    """Return the motors of a measured log much of whose torque the answer leaves, with the share that it does [1].

    Args:
        findings: Fits of one log, and what the held-out log says of them.
    """
    torques, chosen = findings.data.torques, findings.explanations.chosen
    if torques is None or not findings.explanations.detected:
        return {}
    left, changing = torques.usual(chosen.predictor, chosen.theta), np.std(torques.torque, axis=0)
    noise = findings.data.record.torque_noise
    much = left > np.maximum(MOST * changing, 0.0 if noise is None else noise)
    names = findings.model.robot.joint_names
    return {names[motor]: float(left[motor] / changing[motor]) for motor in np.flatnonzero(much & (changing > 0))}


def hidden_from_torques(motors: Sequence[str], findings: Findings) -> tuple[str, ...]:
    """Return those of some motors whose inertia the torques do not confirm: all of a log without measured ones.

    An inertia that is far larger than in the robot file shows in the torques that accelerate it.

    Args:
        motors: The motors.
        findings: Fits of one log, and what the held-out log says of them.
    """
    if findings.data.torques is None:
        return tuple(motors)
    unexplained = unexplained_torques(findings)
    return tuple(motor for motor in motors if motor in unexplained)


def torque_warnings(findings: Findings) -> list[str]:
    """Say which torques are not explained."""
    left = unexplained_torques(findings)
    if not left:
        return []
    shares = ", ".join(f"{name}: {share:.0%}" for name, share in left.items())
    return [
        f"much of what changes of the measured torques is not explained ({shares}), which predicted positions hardly "
        "show there: too little inertia is known to turn, or one that was found is far too large. Give the inertia of "
        "the rotor in the robot file; a force that is not in the library may act"
    ]
