"""Abort messages of the plant."""

from __future__ import annotations

from flexros.logs.stamps import NANOSECONDS

BRAKED = "the plant has braked to zero torque"
"""End of every abort message: what the plant did."""


def controller_timeout_message(k: int, stamp: int, silence: float, resends: int | None = None) -> str:
    """Report that no command came in time.

    Args:
        k: Sample whose command is missing.
        stamp: Its stamp [ns].
        silence: Time without a command [s].
        resends: Number of times the state was sent again; None in real time.
    """
    effort = "" if resends is None else f" although the state was sent again {resends} times"
    return (
        f"no command for sample {k} (stamp {stamp / NANOSECONDS:.4f} s) within {silence:.3g} s{effort}: the controller "
        f"is gone or lacks its reference; {BRAKED}"
    )


def partner_exited_message(k: int, stamp: int) -> str:
    """Report that another node of the run has exited.

    Args:
        k: Sample of the loop, negative before the first.
        stamp: Its stamp [ns].
    """
    when = f"at sample {k} (stamp {stamp / NANOSECONDS:.4f} s); {BRAKED}" if k >= 0 else "before the first sample"
    return f"a partner of the plant exited {when}"


def recorder_timeout_message(confirmed: int, silence: float) -> str:
    """Report that the recorder has stopped confirming.

    Args:
        confirmed: Stamp up to which it has recorded [ns].
        silence: Time without a confirmation [s].
    """
    return (
        f"the recorder has confirmed nothing after stamp {confirmed / NANOSECONDS:.4f} s for {silence:g} s: "
        f"it is gone; {BRAKED}"
    )


def missing_partners_message(listeners: int, observers: int, search: float) -> str:
    """Report that partners were not found.

    Args:
        listeners: Subscriptions to joint_states.
        observers: Recorders that the plant waits for.
        search: Time spent searching [s].
    """
    return (
        f"no partners within {search:g} s: joint_states has {listeners} subscriptions, needed are a controller and "
        f"{observers} recorders; start them with the same ROS_DOMAIN_ID"
    )
