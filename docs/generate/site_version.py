"""Hook of mkdocs: states version and commit of FlexROS at the foot of every page, so that the API has a version."""

from __future__ import annotations

import subprocess
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig

CHECKOUT = Path(__file__).parents[2]


def stated_version() -> str:
    """Return version and commit, the latter where git knows it."""
    command = ["git", "-C", str(CHECKOUT), "rev-parse", "--short=8", "HEAD"]
    commit = subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()  # noqa: S603 - our own words
    return f"FlexROS {metadata.version('flexros')}" + (f", commit {commit}" if commit else "")


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Set the line at the foot."""
    config.copyright = f"Guide and API of {stated_version()}"
    return config
