"""Start of the loop, and its limit ahead of the recorder."""

from __future__ import annotations

from flexros_nodes.protocol.recorder.recorder_window import FIRST_SAMPLE_PATIENCE, PATIENCE_SHARE, RecorderWindow

TIMEOUT = 10.0
"""Time without a confirmation after which the recorder counts as gone [s]."""


def nobody(topic: str) -> bool:
    """No topic has a publisher."""
    return False


def test_window_admits_up_to_its_width_beyond_what_is_recorded() -> None:
    window = RecorderWindow(1_000)
    window.start(10_000)
    assert window.admits(11_000)
    assert not window.admits(11_001)
    window.confirm("", 10_500)
    assert window.admits(11_500)
    assert not window.admits(11_501)


def test_window_of_zero_never_waits() -> None:
    window = RecorderWindow(0)
    window.start(10_000)
    assert window.admits(10**18)


def test_confirmation_of_one_topic_does_not_widen_the_window() -> None:
    window = RecorderWindow(1_000)
    window.start(10_000)
    window.confirm("joint_states", 50_000)
    assert not window.admits(12_000)
    assert window.holds(["joint_states"], 50_000)
    assert not window.holds(["joint_states", "tool_pose"], 50_000)


def test_older_confirmations_change_nothing() -> None:
    window = RecorderWindow(1_000)
    window.start(10_000)
    window.confirm("", 9_000)
    window.confirm("tool_pose", 3)
    window.confirm("tool_pose", 2)
    assert window.admits(11_000)
    assert window.holds(["tool_pose"], 3)


def test_window_follows_the_plants_own_topics_when_the_partner_is_gone() -> None:
    window = RecorderWindow(1_000)
    window.start(10_000)
    window.confirm("joint_states", 10_400)
    window.confirm("tool_pose", 10_300)
    window.follow(["joint_states", "tool_pose"])
    assert window.admits(11_300)
    assert not window.admits(11_301)
    window.confirm("tool_pose", 10_600)
    assert window.admits(11_400)
    assert not window.admits(11_401)


def test_loop_begins_when_every_topic_has_its_first_sample() -> None:
    window = RecorderWindow(1_000, ("joint_states", "tool_pose"), ("joint_commands",))
    window.start(10_000)
    for topic in ("joint_commands", "joint_states", "tool_pose"):
        assert not window.has_begun(nobody, TIMEOUT)
        window.confirm(topic, 10_000)
    assert window.has_begun(nobody, TIMEOUT)


def test_topic_that_a_partner_does_not_send_is_not_awaited_for_ever() -> None:
    window = RecorderWindow(1_000, ("joint_states",), ("joint_reference",))
    window.start(10_000)
    window.confirm("joint_states", 10_000)
    window.wait(FIRST_SAMPLE_PATIENCE)
    assert not window.has_begun(nobody, TIMEOUT)
    window.wait(0.1)
    assert window.has_begun(nobody, TIMEOUT)


def test_topic_that_a_partner_publishes_is_awaited_longer() -> None:
    """Under load it may take seconds until the recorder is connected."""
    window = RecorderWindow(1_000, ("joint_states",), ("joint_reference", "tool_reference"))
    window.start(10_000)
    window.confirm("joint_states", 10_000)
    window.wait(2 * FIRST_SAMPLE_PATIENCE)
    assert not window.has_begun(lambda topic: topic == "tool_reference", TIMEOUT)
    assert window.has_begun(nobody, TIMEOUT)
    window.wait(PATIENCE_SHARE * TIMEOUT)
    assert window.has_begun(lambda topic: topic == "tool_reference", TIMEOUT)


def test_loop_begins_before_the_recorder_counts_as_gone() -> None:
    """A recorder that never receives the topic of a partner does not end the run."""
    window = RecorderWindow(1_000, ("joint_states",), ("tool_reference",))
    window.start(10_000)
    window.confirm("joint_states", 10_000)
    while not window.has_begun(lambda topic: True, TIMEOUT):
        assert window.wait(0.1) < TIMEOUT


def test_loop_never_begins_without_the_topics_of_the_plant() -> None:
    window = RecorderWindow(1_000, ("joint_states",), ("joint_reference",))
    window.start(10_000)
    window.confirm("joint_reference", 10_000)
    assert window.wait(10.0 * FIRST_SAMPLE_PATIENCE) == 10.0 * FIRST_SAMPLE_PATIENCE
    assert not window.has_begun(nobody, TIMEOUT)


def test_silence_is_counted_from_the_last_news() -> None:
    window = RecorderWindow(1_000)
    window.start(10_000)
    window.hold()
    assert window.wait(3.0) == 3.0
    window.confirm("", 10_500)
    assert window.wait(1.0) == 1.0
    window.hold()
    assert (window.wait(2.0), window.waits, window.held) == (2.0, 2, True)
