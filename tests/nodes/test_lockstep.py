"""Bookkeeping of the lock-step protocol."""

from __future__ import annotations

from flexros_nodes.lockstep import Arrival, ControllerLockStep, PlantLockStep, RecorderWindow, Tick

T = 5e-4


def started_plant(**settings: float) -> PlantLockStep:
    lockstep = PlantLockStep(**{"tick_period": 0.02, "partner_timeout": 0.1, "start_timeout": 30.0, **settings})
    lockstep.sent(0)
    lockstep.sent(1)
    return lockstep


def test_only_the_awaited_stamp_answers() -> None:
    lockstep = PlantLockStep(0.02, 1.0, 30.0)
    lockstep.sent(1_000_000_000)
    assert not lockstep.answers(999_500_000)
    assert not lockstep.answers(1_000_500_000)
    assert lockstep.answers(1_000_000_000)
    assert lockstep.stale == 2


def test_state_is_sent_again_only_after_a_whole_period_without_progress() -> None:
    lockstep = started_plant()
    assert lockstep.tick() is Tick.WAIT  # the first tick only sees what is in flight
    assert lockstep.tick() is Tick.RESEND
    lockstep.sent(2)
    assert lockstep.tick() is Tick.WAIT
    assert lockstep.resends == 1


def test_partner_is_given_up_after_its_timeout() -> None:
    lockstep = started_plant()
    ticks = [lockstep.tick() for _ in range(6)]
    assert ticks == [Tick.WAIT, *[Tick.RESEND] * 4, Tick.GIVE_UP]


def test_first_state_is_repeated_every_tenth_of_a_second_and_has_longer() -> None:
    lockstep = PlantLockStep(0.02, 0.1, 30.0)
    lockstep.sent(0)
    ticks = [lockstep.tick() for _ in range(1 + 50)]
    assert ticks.count(Tick.RESEND) == 10
    assert Tick.GIVE_UP not in ticks
    assert (lockstep.handshakes, lockstep.resends) == (10, 0)


def test_first_state_is_given_up_in_the_end() -> None:
    lockstep = PlantLockStep(0.1, 5.0, 1.0)
    lockstep.sent(0)
    ticks = [lockstep.tick() for _ in range(12)]
    assert ticks.index(Tick.GIVE_UP) in (10, 11)


def test_plant_that_waits_itself_does_not_blame_its_partner() -> None:
    lockstep = started_plant()
    for _ in range(4):
        lockstep.tick()
    lockstep.hold()
    assert lockstep.tick() is Tick.WAIT


def test_controller_tells_new_repeated_and_old_stamps() -> None:
    lockstep = ControllerLockStep(T)
    stamps = (1_000_000_000, 1_000_500_000, 1_000_500_000, 1_000_000_000)
    assert [lockstep.arrival(stamp) for stamp in stamps] == [
        Arrival.NEW,
        Arrival.NEW,
        Arrival.REPEATED,
        Arrival.OLD,
    ]
    assert (lockstep.repeated, lockstep.old, lockstep.missed, lockstep.last) == (1, 1, 0, 1_000_500_000)


def test_controller_counts_samples_it_never_saw() -> None:
    lockstep = ControllerLockStep(T)
    lockstep.arrival(1_000_000_000)
    lockstep.arrival(1_002_000_000)
    assert lockstep.missed == 3


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
