"""Shutdown of the plant."""

from __future__ import annotations

from flexros.errors import RunError
from flexros_nodes.protocol.loop.shutdown import FLUSH_TIMEOUT, Shutdown


def test_complete_run_does_not_brake() -> None:
    assert not Shutdown(None, 0).braking


def test_aborted_run_brakes_for_its_samples() -> None:
    shutdown = Shutdown(RunError("broken"), 3)
    while shutdown.braking:
        shutdown.count_brake_sample()
    assert shutdown.braked == 3


def test_plant_that_cannot_advance_stops_braking() -> None:
    shutdown = Shutdown(RunError("broken"), 3)
    shutdown.count_brake_sample()
    shutdown.stop_braking()
    assert not shutdown.braking
    assert shutdown.braked == 1


def test_wait_for_the_recorder_is_limited_and_restarts_with_every_sample() -> None:
    shutdown = Shutdown(RunError("broken"), 3)
    assert not shutdown.timed_out(FLUSH_TIMEOUT)
    shutdown.count_brake_sample()
    assert not shutdown.timed_out(FLUSH_TIMEOUT)
    assert shutdown.timed_out(0.1)
