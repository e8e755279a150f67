"""A hidden deviation: an effect of the library or another cause, at a location."""

from __future__ import annotations

from pydantic import Field

from flexros.config.settings import Settings


class Deviation(Settings):
    """One deviation of the simulated robot from its model."""

    effect: str = Field(description="name of the effect, or of a cause outside the library")
    location: str = Field(description="motor, spring, body, 'tool', 'base' or 'all'")
    parameters: dict[str, float] = Field(description="its numbers [SI]")

    @property
    def place(self) -> str:
        """Effect and location as one text."""
        return f"{self.effect}@{self.location}"
