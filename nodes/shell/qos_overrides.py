"""Limits of the standard parameters `qos_overrides.*`.

Both ends of a topic connect only if the publisher offers at least what the subscription requests. So a publisher may
offer more than its profile in `msgs_config/qos.yaml`, and a subscription may request less, but not vice versa.
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
    """Return why a quality of service would break the loop, empty if it would not.

    Args:
        profile: Profile of `qos.yaml` for this end of the topic.
        publisher: Whether this end is a publisher.
        history: History policy of ROS 2, e.g. "keep_last".
        depth: Number of messages kept.
        reliability: "reliable", "best_effort" or another word.
        durability: "volatile", "transient_local" or another word.

    Returns:
        What is given, what is allowed and why; empty if it is allowed.
    """
    if history != "keep_last":
        return f"history is {history}, allowed is keep_last: with keep_all a slow reader would block its writer"
    if not profile.least_depth <= depth <= MOST_DEPTH:
        why = (
            "fewer would be overwritten before they are read" if depth < profile.least_depth else "more have no effect"
        )
        return f"depth is {depth}, allowed is {profile.least_depth} to {MOST_DEPTH}: {why}"
    for policy, value in (("reliability", reliability), ("durability", durability)):
        weak, strong = _STRENGTH[policy]
        configured = getattr(profile, policy)
        allowed = {configured, strong} if publisher else {configured, weak}
        why = "a subscription requests it" if publisher else "a publisher that offers less would not connect"
        if not publisher and policy == "reliability" and profile.lossless:
            allowed, why = {configured}, "none of these messages may be lost"
        if value not in allowed:
            return f"{policy} is {value}, allowed is {' or '.join(sorted(allowed))}: {why}"
    return ""
