"""The end of a search by time or from outside, and what is left of the time then."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from flexros.gap.deadline import FINISHING, LEAST_FINISHING, Deadline


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        return self.time


@pytest.fixture
def clock() -> Clock:
    return Clock()


def test_without_limit_there_is_always_time(clock: Clock) -> None:
    deadline = Deadline(clock=clock)
    clock.time += 1e9
    assert not deadline.over
    assert not deadline.stops()
    assert deadline.partial is None


def test_the_step_that_is_cut_short_first_is_kept_with_the_time(clock: Clock) -> None:
    deadline = Deadline(40.0, clock=clock)
    deadline.begin("candidates")
    clock.time += 39.0
    assert not deadline.stops()
    deadline.begin("single effects")
    clock.time += 2.0
    assert deadline.stops()
    deadline.begin("effects exchanged")
    clock.time += 5.0
    assert deadline.stops()
    partial = deadline.partial
    assert partial is not None
    assert (partial.reason, partial.step, partial.after) == ("time_limit", "single effects", 41.0)


def test_nothing_is_lacking_where_no_step_was_left_out(clock: Clock) -> None:
    deadline = Deadline(40.0, clock=clock)
    clock.time += 41.0
    assert deadline.over
    assert not deadline.stops_finishing()
    assert deadline.partial is None


def test_an_interruption_counts_from_the_moment_that_it_is_noticed(clock: Clock) -> None:
    asked: list[bool] = []
    deadline = Deadline(interrupted=lambda: bool(asked), clock=clock)
    clock.time += 30.0
    assert not deadline.stops()
    asked.append(True)
    assert deadline.stops()
    assert deadline.partial is not None
    assert (deadline.partial.reason, deadline.partial.after) == ("interrupted", 30.0)


def test_a_thread_that_read_the_clock_in_time_leaves_the_reason_of_another(clock: Clock) -> None:
    others: list[Deadline] = []

    def read() -> float:
        earlier = clock.time
        if others:
            clock.time += 2.0
            assert others.pop().stops()
        return earlier

    deadline = Deadline(40.0, clock=read)
    clock.time += 39.0
    others.append(deadline)
    assert deadline.over
    assert deadline.partial is not None
    assert (deadline.partial.reason, deadline.partial.after) == ("time_limit", 41.0)


@pytest.mark.parametrize(("limit", "left"), [(100.0, 100.0 * FINISHING), (1.0, LEAST_FINISHING)])
def test_there_is_a_little_time_to_finish_in(clock: Clock, limit: float, left: float) -> None:
    deadline = Deadline(limit, clock=clock)
    clock.time += limit + 0.99 * left
    assert deadline.over
    assert not deadline.spent
    clock.time += 0.02 * left
    assert deadline.spent


def begun(deadline: Deadline, *, finishing: bool = False) -> Callable[[], bool]:
    return deadline.of_fit(finishing=finishing)


def test_a_fit_that_began_in_time_ends_with_it_and_one_that_finishes_later(clock: Clock) -> None:
    deadline = Deadline(10.0, clock=clock)
    growing, finishing = begun(deadline), begun(deadline, finishing=True)
    clock.time += 10.5
    late = begun(deadline)
    assert [growing(), finishing(), late()] == [True, False, False]
    clock.time += 10.0
    assert [growing(), finishing(), late()] == [True, True, True]


def test_what_was_abandoned_ends_at_once(clock: Clock) -> None:
    deadline = Deadline(clock=clock)
    finishing = deadline.of_fit(finishing=True)
    deadline.abandon()
    assert finishing()


def test_what_an_answer_leaves_out_is_noted_once_the_time_to_finish_it_is_over(clock: Clock) -> None:
    deadline = Deadline(40.0, clock=clock)
    deadline.begin("answer")
    clock.time += 41.0
    assert not deadline.leaves_out("first part")
    clock.time += 40.0 * FINISHING
    assert deadline.leaves_out("second part")
    assert deadline.leaves_out("second part")
    assert deadline.partial is not None
    assert (deadline.partial.step, deadline.partial.left_out) == ("answer", ("second part",))


def test_a_part_of_the_limit_is_kept_for_the_steps_after_the_search(clock: Clock) -> None:
    """A delay that made the held-out log worse was named, as a search took all the time."""
    deadline = Deadline(100.0, kept=0.2, clock=clock)
    deadline.begin("effects exchanged")
    clock.time += 81.0
    assert deadline.stops()
    clock.time += 15.0
    assert deadline.stops_finishing()
    deadline.release()
    deadline.begin("effects on held-out data")
    assert not deadline.stops()
    clock.time += 5.0
    assert deadline.stops()
    assert not deadline.stops_finishing()
    partial = deadline.partial
    assert partial is not None
    assert (partial.reason, partial.step, partial.after) == ("time_limit", "effects exchanged", 81.0)


def test_an_interruption_leaves_no_time_for_the_steps_after_the_search(clock: Clock) -> None:
    deadline = Deadline(100.0, lambda: True, kept=0.2, clock=clock)
    assert deadline.stops()
    deadline.release()
    assert deadline.stops()
