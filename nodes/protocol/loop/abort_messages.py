"""Sentences of a plant whose run breaks off, free of ROS."""

from __future__ import annotations

from flexros.logs.stamps import NANOSECONDS

BRAKED = "the plant has braked to zero torque"
"""What a plant does whose run breaks off, for the user to read."""


def silence_text(k: int, stamp: int, silence: float, resends: int | None = None) -> str:
    """Say that the controller has fallen silent.

    Args:
        k: Sample whose command is missing.
        stamp: Its stamp [ns].
        silence: Time without a command [s].
        resends: Times that the state was sent again, None in real time.
    """
    effort = "" if resends is None else f" although the state was sent again {resends} times"
    return (
        f"no command for sample {k} (stamp {stamp / NANOSECONDS:.4f} s) within {silence:.3g} s{effort}: the controller "
        f"is gone or lacks its reference; {BRAKED}"
    )


def partner_ended_text(k: int, stamp: int) -> str:
    """Say that another node of the run has ended.

    Args:
        k: Sample of the loop, negative before the first.
        stamp: Its stamp [ns].
    """
    when = f"at sample {k} (stamp {stamp / NANOSECONDS:.4f} s); {BRAKED}" if k >= 0 else "before the first sample"
    return f"a partner of the plant has ended {when}"


def recorder_silence_text(confirmed: int, silence: float) -> str:
    """Say that the recorder has fallen silent.

    Args:
        confirmed: Stamp up to which it has recorded [ns].
        silence: Time without a confirmation [s].
    """
    return (
        f"the recorder has confirmed nothing after stamp {confirmed / NANOSECONDS:.4f} s for {silence:g} s: "
        f"it is gone; {BRAKED}"
    )


def no_partners_text(listeners: int, observers: int, search: float) -> str:
    """Say that partners are missing.

    Args:
        listeners: Subscriptions to joint_states.
        observers: Recorders that the plant waits for.
        search: Time that it has searched [s].
    """
    return (
        f"no partners within {search:g} s: joint_states has {listeners} subscriptions, needed are a controller and "
        f"{observers} recorders; start them with the same ROS_DOMAIN_ID"
    )
