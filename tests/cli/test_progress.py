"""Progress where there is no terminal: lines on stderr."""

from __future__ import annotations

import time

import pytest

from flexros.cli.progress import EVERY, Lines, ProgressBar, line, progress_shown, time_left, working


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.time = 5.0

    def __call__(self) -> float:
        return self.time


def test_a_stage_gets_a_line_when_it_begins_and_then_one_in_a_while(capfd: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    show = Lines(clock)
    for step in range(40):
        clock.time = 5.0 + step
        show("first" if step < 15 else "second", step / 40)
    out, err = capfd.readouterr()
    times = [int(line.split()[1]) for line in err.splitlines()]
    assert times == [0, 10, 15, 25, 35]
    assert err.splitlines()[3] == "flexros: 25 s: second, 62 % done, about 15 s left"
    assert out == ""


def test_steps_that_take_turns_are_no_new_stages(capfd: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    show = Lines(clock)
    for step in range(20):
        clock.time = 5.0 + 0.4 * EVERY * step
        show(("grown", "reduced")[step % 2], 0.5)
    assert len(capfd.readouterr().err.splitlines()) <= 2 + 0.4 * 20


def test_without_a_terminal_there_are_lines_on_stderr(capfd: pytest.CaptureFixture[str]) -> None:
    with progress_shown() as show:
        show("reading", 0.25)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "flexros: 0 s: reading, 25 % done\n")


def test_the_share_never_falls(capfd: pytest.CaptureFixture[str]) -> None:
    show = Lines(Clock())
    show("candidates", 0.62)
    show("single effects", 0.59)
    assert "single effects, 62 % done" in capfd.readouterr().err


def test_the_time_left_is_known_once_something_is_done() -> None:
    assert time_left(1.0, 0.5) is None
    assert time_left(20.0, 0.001) is None
    assert time_left(40.0, 0.01) == pytest.approx(3960.0), "hours: the first of 100 cases tells"
    assert line(40.0, "crowds", 0.0) == "flexros: 40 s: crowds, 0 % done, time left not known"
    assert time_left(30.0, 0.25) == 90.0
    assert line(600.0, "fits", 0.5) == "flexros: 600 s: fits, 50 % done, about 10 min left"


def test_what_stands_at_a_share_takes_at_least_as_long_again(capfd: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    show = Lines(clock)
    for elapsed, share in ((60.0, 0.84), (120.0, 0.845), (180.0, 0.85)):
        clock.time = 5.0 + elapsed
        show("effects together", share)
    last = capfd.readouterr().err.splitlines()[-1]
    assert last == "flexros: 180 s: effects together, 85 % done, about 2 min left"


def test_a_bar_without_a_terminal_is_silent_at_first_and_then_prints_lines(capfd: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    with ProgressBar(clock=clock) as bar:
        task = bar.add_task("simulating", total=40)
        for step in range(1, 41):
            clock.time = 5.0 + 0.5 * step
            bar.update(task, completed=step)
    assert capfd.readouterr().err.splitlines() == [
        "flexros: 2 s: simulating, 10 % done, about 18 s left",
        "flexros: 12 s: simulating, 60 % done, about 8 s left",
    ]


def test_a_bar_within_another_one_is_silent(capfd: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    with ProgressBar(shown=False, clock=clock) as bar:
        task = bar.add_task("simulating", total=2)
        clock.time = 50.0
        bar.advance(task)
    assert capfd.readouterr().err == ""


def test_work_of_unknown_length_leaves_what_it_raises() -> None:
    with pytest.raises(KeyError), working("looking"):
        raise KeyError


def test_work_that_does_not_report_is_spoken_of(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flexros.cli.progress.QUIET", 0.0)
    monkeypatch.setattr("flexros.cli.progress._BEAT", 0.01)
    said = ""
    with working("preparing"):
        for _ in range(500):
            if said:
                break
            time.sleep(0.01)
            said = capfd.readouterr().err
    assert said == "flexros: 0 s: preparing, time left not known\n"
