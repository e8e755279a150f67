"""What the standard parameters `qos_overrides.*` may change, free of ROS.

Both ends of a topic connect only if the publisher offers at least what the subscription asks for. So a publisher may
offer more than its profile in `msgs_config/qos.yaml`, a subscription may ask for less, and neither the other way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.config.topics import QosProfile

MOST_DEPTH = 100_000
"""Largest depth, chosen: more is taken for a mistake."""

_STRENGTH = {"reliability": ("best_effort", "reliable"), "durability": ("volatile", "transient_local")}


def override_problem(
    profile: QosProfile, publisher: bool, *, history: str, depth: int, reliability: str, durability: str
) -> str:
    """Say why a quality of service would break the loop.

    Args:
        profile: What `qos.yaml` states for this end of the topic.
        publisher: Whether it is a publisher; else a subscription.
        history: "keep_last" or another word of ROS 2.
        depth: Number of messages kept.
        reliability: "reliable", "best_effort" or another word.
        durability: "volatile", "transient_local" or another word.

    Returns:
        What is given, what is allowed and why; empty if it is allowed.
    """
    if history != "keep_last":
        return f"history is {history}, allowed is keep_last: with keep_all a slow reader would stop its writer"
    if not profile.least_depth <= depth <= MOST_DEPTH:
        why = (
            "with fewer, some would be overwritten before they are read"
            if depth < profile.least_depth
            else "more help no reader"
        )
        return f"depth is {depth}, allowed is {profile.least_depth} to {MOST_DEPTH}: {why}"
    for policy, given in (("reliability", reliability), ("durability", durability)):
        weak, strong = _STRENGTH[policy]
        stated = getattr(profile, policy)
        allowed = {stated, strong} if publisher else {stated, weak}
        why = "a subscription asks for it" if publisher else "a publisher that offers less would not be heard"
        if not publisher and policy == "reliability" and profile.lossless:
            allowed, why = {stated}, "none of these messages may be lost"
        if given not in allowed:
            return f"{policy} is {given}, allowed is {' or '.join(sorted(allowed))}: {why}"
    return ""
