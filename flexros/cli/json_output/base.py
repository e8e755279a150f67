"""Base of what commands print as JSON."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Output(BaseModel):
    """A JSON object of a command: every key is described, and there are no others."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True)


class OpenOutput(Output):
    """A JSON object with further keys, which its description names."""

    model_config = ConfigDict(extra="allow")
