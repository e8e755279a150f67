"""How a plant ends."""

from __future__ import annotations

from flexros.errors import RunError
from flexros_nodes.protocol.loop.shutdown import GOODBYE_TIMEOUT, Ending


def test_run_that_is_done_does_not_brake() -> None:
    assert not Ending(None, 0).brakes


def test_broken_run_brakes_for_its_samples() -> None:
    ending = Ending(RunError("broken"), 3)
    while ending.brakes:
        ending.brake()
    assert ending.braked == 3


def test_plant_that_cannot_move_on_brakes_no_more() -> None:
    ending = Ending(RunError("broken"), 3)
    ending.brake()
    ending.give_up_braking()
    assert not ending.brakes
    assert ending.braked == 1


def test_wait_for_the_recorder_is_limited_and_begins_anew_with_every_sample() -> None:
    ending = Ending(RunError("broken"), 3)
    assert not ending.wait(GOODBYE_TIMEOUT)
    ending.brake()
    assert not ending.wait(GOODBYE_TIMEOUT)
    assert ending.wait(0.1)
