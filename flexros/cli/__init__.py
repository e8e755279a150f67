"""The `flexros` command."""

from __future__ import annotations

from flexros.cli.app import main

__all__ = ["main"]
