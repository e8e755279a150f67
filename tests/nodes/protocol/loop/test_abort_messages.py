"""Abort messages of the plant."""

from __future__ import annotations

from flexros_nodes.protocol.loop.abort_messages import (
    controller_timeout_message,
    missing_partners_message,
    partner_exited_message,
    recorder_timeout_message,
)


def test_controller_timeout_states_sample_stamp_and_resends() -> None:
    assert controller_timeout_message(12, 1_006_000_000, 5.0, 249) == (
        "no command for sample 12 (stamp 1.0060 s) within 5 s although the state was sent again 249 times: the "
        "controller is gone or lacks its reference; the plant has braked to zero torque"
    )


def test_controller_timeout_in_real_time_states_no_resends() -> None:
    assert controller_timeout_message(12, 1_006_000_000, 0.1).startswith(
        "no command for sample 12 (stamp 1.0060 s) within 0.1 s: the"
    )


def test_exit_of_a_partner_states_the_sample() -> None:
    assert partner_exited_message(12, 1_006_000_000) == (
        "a partner of the plant exited at sample 12 (stamp 1.0060 s); the plant has braked to zero torque"
    )
    assert partner_exited_message(-1, 0) == "a partner of the plant exited before the first sample"


def test_recorder_timeout_states_the_last_stamp() -> None:
    assert recorder_timeout_message(1_500_000_000, 20.0) == (
        "the recorder has confirmed nothing after stamp 1.5000 s for 20 s: it is gone; "
        "the plant has braked to zero torque"
    )


def test_missing_partners_are_counted() -> None:
    assert missing_partners_message(1, 3, 0.2) == (
        "no partners within 0.2 s: joint_states has 1 subscriptions, needed are a controller and 3 recorders; start "
        "them with the same ROS_DOMAIN_ID"
    )
