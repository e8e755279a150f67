"""Services of the plant: start, pause, step and reset of its loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.logs.stamps import NANOSECONDS
from flexros_nodes.shell.topic_node import Answer

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros_nodes.plant.node import PlantNode


class PlantServices:
    """What a user may ask of the loop, of type std_srvs/srv/Trigger, below the plant's name.

    1. `start` lets a loop go on that is paused, or that waits for its start (parameter `begin_at_once` is false).
    2. `pause` lets it stand still. The command of the present sample is kept, so that a loop in lock-step goes on later
       as if nothing had been. In real time the schedule begins anew after the pause.
    3. `step` lets one sample follow in a pause.
    4. `reset` takes the robot back to its initial state, before the first sample, whose stamp is 1 s. Controller and
       feedforward begin anew with it; a log cannot, so that it is refused while a recorder is there. A loop that is
       paused remains so.

    Args:
        plant: The plant node.
    """

    def __init__(self, plant: PlantNode) -> None:
        self._plant = plant
        self._loop = plant.loop
        for answer in (self._start, self._pause, self._step, self._reset):
            plant.offer(answer.__name__.lstrip("_"), self._unless_over(answer))

    def _unless_over(self, answer: Callable[[], Answer]) -> Callable[[], Answer]:
        """Let a service refuse when the run ends."""
        return lambda: Answer(False, f"the run ends at {self._place()}") if self._loop.over else answer()

    def _place(self) -> str:
        if self._loop.sample < 0:
            return "its beginning; it looks for controller and recorder"
        return f"sample {self._loop.sample} (stamp {self._loop.stamp / NANOSECONDS:.4f} s)"

    def _start(self) -> Answer:
        if not self._loop.pause.on:
            return Answer(False, f"the plant is not paused; it is at {self._place()}")
        place = self._place()
        self._loop.end_pause()
        return Answer(True, f"the plant goes on from {place}")

    def _pause(self) -> Answer:
        already = " already" if self._loop.pause.on else ""
        self._loop.begin_pause()
        return Answer(True, f"the plant is paused{already} at {self._place()}")

    def _step(self) -> Answer:
        loop, sample = self._loop, self._loop.sample
        if not loop.pause.on:
            return Answer(False, "the plant is not paused; call pause before a step")
        if sample < 0:
            return Answer(False, f"the plant is at {self._place()}; step when they are there")
        if loop.pause.step_is_due:
            return Answer(False, f"the step before still waits for the command of sample {sample}; try again")
        loop.step()
        if loop.over:
            return Answer(True, f"the run ends at {self._place()}")
        if loop.sample == sample:
            return Answer(True, f"sample {sample + 1} follows with the command of sample {sample}")
        return Answer(True, f"the plant is at {self._place()}")

    def _reset(self) -> Answer:
        if self._loop.sample <= 0:
            return Answer(True, f"the plant is at {self._place()}")
        if self._loop.messages.is_published("recorder_progress"):
            return Answer(
                False,
                "a recorder is there, whose log cannot go back to the first sample; end this run and begin another, or "
                "end the recorder and reset then",
            )
        self._plant.reset()
        return Answer(True, "the plant is back before its first sample")
