"""Bookkeeping of the lock-step protocol."""

from __future__ import annotations

import pytest

from flexros_nodes.protocol.loop.lockstep import Arrival, ControllerLockStep, PlantLockStep, RestartDetector, Tick

T = 5e-4


def started_plant() -> PlantLockStep:
    lockstep = PlantLockStep(tick_period=0.02, resend_timeout=0.02, partner_timeout=0.1, start_timeout=30.0)
    lockstep.sent(0)
    lockstep.sent(1)
    return lockstep


def test_only_the_awaited_stamp_answers() -> None:
    lockstep = PlantLockStep(0.02, 0.02, 1.0, 30.0)
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
    lockstep = PlantLockStep(0.02, 0.02, 0.1, 30.0)
    lockstep.sent(0)
    ticks = [lockstep.tick() for _ in range(1 + 50)]
    assert ticks.count(Tick.RESEND) == 10
    assert Tick.GIVE_UP not in ticks
    assert (lockstep.handshakes, lockstep.resends) == (10, 0)


def test_first_state_is_given_up_in_the_end() -> None:
    lockstep = PlantLockStep(0.1, 0.02, 5.0, 1.0)
    lockstep.sent(0)
    ticks = [lockstep.tick() for _ in range(12)]
    assert ticks.index(Tick.GIVE_UP) in (10, 11)


def test_plant_that_waits_itself_does_not_blame_its_partner() -> None:
    lockstep = started_plant()
    for _ in range(4):
        lockstep.tick()
    lockstep.hold()
    assert lockstep.tick() is Tick.WAIT


def quick_plant(samples_per_tick: int) -> PlantLockStep:
    """A loop at work for half a second, whose last state then stays unanswered."""
    lockstep = PlantLockStep(0.002, 0.02, 5.0, 30.0)
    for k in range(250 * samples_per_tick):
        lockstep.sent(k)
        if k % samples_per_tick == 0:
            assert lockstep.tick() is Tick.WAIT
    return lockstep


def waits_until_resend(lockstep: PlantLockStep, most: int = 20) -> int:
    return next(n for n in range(1, most) if lockstep.tick() is Tick.RESEND)


def test_quick_loop_sends_again_soon_and_then_ever_more_slowly() -> None:
    lockstep = quick_plant(samples_per_tick=10)  # a round trip of 0.2 ms
    assert lockstep.tick() is Tick.WAIT
    assert [waits_until_resend(lockstep) for _ in range(5)] == [1, 2, 4, 8, 10]
    assert lockstep.resends == 5


def test_slow_loop_sends_again_after_five_round_trips() -> None:
    lockstep = quick_plant(samples_per_tick=1)  # a round trip of 2 ms
    assert waits_until_resend(lockstep) == 5


@pytest.mark.parametrize("ticks_before_the_second_answer", [0, 1])
def test_second_answer_makes_the_plant_patient(ticks_before_the_second_answer: int) -> None:
    lockstep = quick_plant(samples_per_tick=10)
    stamp = lockstep.awaited
    waits_until_resend(lockstep)
    lockstep.sent(stamp + 1)  # the answer was on its way
    for _ in range(ticks_before_the_second_answer):
        lockstep.tick()
    assert not lockstep.answers(stamp)
    lockstep.sent(stamp + 2)
    assert lockstep.tick() is Tick.WAIT
    assert waits_until_resend(lockstep) > 5


def test_lost_state_does_not_make_the_plant_patient() -> None:
    lockstep = quick_plant(samples_per_tick=10)
    waits_until_resend(lockstep)
    lockstep.sent(lockstep.awaited + 1)
    assert lockstep.tick() is Tick.WAIT
    assert waits_until_resend(lockstep) == 1


def test_controller_distinguishes_new_repeated_and_old_stamps() -> None:
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


def test_first_stamp_three_times_is_a_restart() -> None:
    lockstep = ControllerLockStep(T)
    for stamp in (1_000_000_000, 1_000_500_000):
        lockstep.arrival(stamp)
    arrivals = [lockstep.arrival(1_000_000_000) for _ in range(3)]
    assert arrivals == [Arrival.OLD, Arrival.OLD, Arrival.RESTARTED]


def test_late_repeats_of_the_first_stamp_are_no_restart() -> None:
    detector = RestartDetector()
    assert not any(detector.restarted(newest) for newest in (1, 1, 2, 2, 3, 4, 4))


def test_older_stamps_are_no_restart() -> None:
    lockstep = ControllerLockStep(T)
    lockstep.arrival(1_001_000_000)
    assert {lockstep.arrival(1_000_500_000) for _ in range(5)} == {Arrival.OLD}
