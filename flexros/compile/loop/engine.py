"""What carries out a closed loop: the seam between machine code and the CasADi virtual machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.compile.loop.arrays import LoopJob


class LoopEngine(Protocol):
    """Runs whole jobs, and prepares the two halves of a sample on fixed arrays (all with a last axis of lanes)."""

    def run(self, job: LoopJob) -> int:
        """Run all samples of a job in place; return how many were done before every lane had diverged."""
        ...

    def measure(
        self, plant: FloatArray, noise: FloatArray, parameters: FloatArray, encoder: FloatArray, tool_pose: FloatArray
    ) -> Callable[[], None]:
        """Prepare the reading of encoders and tool pose."""
        ...

    def advance(
        self,
        plant: FloatArray,
        line: FloatArray,
        command: FloatArray,
        disturbance: FloatArray,
        parameters: FloatArray,
    ) -> Callable[[], None]:
        """Prepare the step from one sample to the next."""
        ...
