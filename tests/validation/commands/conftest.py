"""Commands of this room are run as those of the command line."""

from __future__ import annotations

from tests.cli.conftest import flexros

__all__ = ["flexros"]
