"""JSON of doctor and clean."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from flexros.cli.json_output.base import Output


class Checked(Output):
    """A finding of the doctor."""

    name: str = Field(description="what was checked")
    state: str = Field(description="ok, limited or broken")
    text: str = Field(description="what was found")
    remedy: str = Field(description="what to do; empty where it is ok")
    facts: dict[str, Any] = Field(description="values behind it, units in the keys")


class Examined(Output):
    """The installation on this machine."""

    healthy: bool = Field(description="whether nothing is broken")
    findings: list[Checked] = Field(description="in the order of the checks")


class Leftover(Output):
    """A folder that can be removed."""

    path: str = Field(description="the folder")
    what: str = Field(description="what it holds")
    bytes: int = Field(description="size of its files [bytes]")
    files: int = Field(description="number of its files [1]")
    in_use: bool = Field(description="whether it is kept because a process uses it")


class Cleaned(Output):
    """What clean has found and removed."""

    found: list[Leftover] = Field(description="caches and temporary folders")
    removed: list[str] = Field(description="folders that were removed")
    freed_bytes: int = Field(description="size of these [bytes]")
