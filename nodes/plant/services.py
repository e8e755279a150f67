"""Services of the plant: start, pause, step and reset of its loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.logs.stamps import NANOSECONDS
from flexros_nodes.shell.topic_node import Answer

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros_nodes.plant.loop import PlantLoop
    from flexros_nodes.shell.topic_node import AbstractTopicNode


class PlantServices:
    """Services of type std_srvs/srv/Trigger in the namespace of the plant node.

    1. `start` resumes a paused loop, or starts one that waits for it (parameter `begin_at_once` is false).
    2. `pause` pauses the loop. The command of the present sample is kept, so that a loop in lock-step continues later
       without any difference. In real time the schedule restarts after the pause.
    3. `step` lets one sample pass in a pause.
    4. `reset` returns the robot to its initial state, before the first sample, whose stamp is 1 s. Controller and
       feedforward restart with it. A log cannot, so the service is refused while a recorder is connected. A paused
       loop remains paused.

    Args:
        node: The plant node.
        loop: Its loop.
        reset: Returns node and loop to the state before the first sample.
    """

    def __init__(self, node: AbstractTopicNode, loop: PlantLoop, reset: Callable[[], None]) -> None:
        self._loop = loop
        self._reset_plant = reset
        for answer in (self._start, self._pause, self._step, self._reset):
            node.offer(answer.__name__.lstrip("_"), self._unless_over(answer))

    def _unless_over(self, answer: Callable[[], Answer]) -> Callable[[], Answer]:
        """Wrap a service so that it is refused when the run ends."""
        return lambda: Answer(False, f"the run ends at {self._position()}") if self._loop.over else answer()

    def _position(self) -> str:
        if self._loop.sample < 0:
            return "its beginning, waiting for controller and recorder"
        return f"sample {self._loop.sample} (stamp {self._loop.stamp / NANOSECONDS:.4f} s)"

    def _start(self) -> Answer:
        if not self._loop.pause.on:
            return Answer(False, f"the plant is not paused; it is at {self._position()}")
        position = self._position()
        self._loop.end_pause()
        return Answer(True, f"the plant continues from {position}")

    def _pause(self) -> Answer:
        already = " already" if self._loop.pause.on else ""
        self._loop.begin_pause()
        return Answer(True, f"the plant is paused{already} at {self._position()}")

    def _step(self) -> Answer:
        loop, sample = self._loop, self._loop.sample
        if not loop.pause.on:
            return Answer(False, "the plant is not paused; call pause before a step")
        if sample < 0:
            return Answer(False, f"the plant is at {self._position()}; step once they are connected")
        if loop.pause.step_is_due:
            return Answer(False, f"the previous step still waits for the command of sample {sample}; try again")
        loop.step()
        if loop.over:
            return Answer(True, f"the run ends at {self._position()}")
        if loop.sample == sample:
            return Answer(True, f"sample {sample + 1} follows with the command of sample {sample}")
        return Answer(True, f"the plant is at {self._position()}")

    def _reset(self) -> Answer:
        if self._loop.sample <= 0:
            return Answer(True, f"the plant is at {self._position()}")
        if self._loop.messages.is_published("recorder_progress"):
            return Answer(
                False,
                "a recorder is connected, and its log cannot return to the first sample; end this run and start "
                "another, or end the recorder first",
            )
        self._reset_plant()
        return Answer(True, "the plant is back before its first sample")
