"""Sentences of a plant whose run breaks off."""

from __future__ import annotations

from flexros_nodes.protocol.loop.abort_messages import (
    no_partners_text,
    partner_ended_text,
    recorder_silence_text,
    silence_text,
)


def test_silence_is_told_with_sample_time_and_resends() -> None:
    assert silence_text(12, 1_006_000_000, 5.0, 249) == (
        "no command for sample 12 (stamp 1.0060 s) within 5 s although the state was sent again 249 times: the "
        "controller is gone or lacks its reference; the plant has braked to zero torque"
    )


def test_silence_in_real_time_says_nothing_of_resends() -> None:
    assert silence_text(12, 1_006_000_000, 0.1).startswith(
        "no command for sample 12 (stamp 1.0060 s) within 0.1 s: the"
    )


def test_end_of_a_partner_is_told_with_the_sample() -> None:
    assert partner_ended_text(12, 1_006_000_000) == (
        "a partner of the plant has ended at sample 12 (stamp 1.0060 s); the plant has braked to zero torque"
    )
    assert partner_ended_text(-1, 0) == "a partner of the plant has ended before the first sample"


def test_silent_recorder_is_told_with_its_last_stamp() -> None:
    assert recorder_silence_text(1_500_000_000, 20.0) == (
        "the recorder has confirmed nothing after stamp 1.5000 s for 20 s: it is gone; "
        "the plant has braked to zero torque"
    )


def test_missing_partners_are_counted() -> None:
    assert no_partners_text(1, 3, 0.2) == (
        "no partners within 0.2 s: joint_states has 1 subscriptions, needed are a controller and 3 recorders; start "
        "them with the same ROS_DOMAIN_ID"
    )
