"""A pause that may let single samples pass."""

from __future__ import annotations

from flexros_nodes.protocol.loop.pause import Pause


def test_step_lets_one_sample_pass() -> None:
    pause = Pause(True, 1.0)
    assert pause.holds
    pause.step()
    assert not pause.holds
    assert pause.passed(2.0) == 1.0
    assert pause.holds
    assert pause.on


def test_end_returns_the_paused_time() -> None:
    pause = Pause(False, 0.0)
    pause.begin(3.0)
    pause.step()
    pause.passed(4.0)
    assert pause.end(4.5) == 0.5
    assert not pause.on
    assert not pause.holds


def test_sample_that_passes_without_a_pause_has_not_waited() -> None:
    assert Pause(False, 1.0).passed(2.0) == 0.0


def test_step_that_is_due_ends_with_the_pause() -> None:
    pause = Pause(True, 0.0)
    pause.step()
    pause.end(1.0)
    pause.begin(2.0)
    assert pause.holds
