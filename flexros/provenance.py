"""Provenance of results in addition to their input: versions of packages, commit, and machine."""

from __future__ import annotations

import os
import platform
import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

NUMERIC_PACKAGES = ("flexros", "casadi", "llvmlite", "numpy", "scipy")
"""Packages that determine the results of a run."""


def versions(packages: tuple[str, ...] = NUMERIC_PACKAGES) -> dict[str, str]:
    """Return the versions of packages by name, that of Python first; "not installed" for missing ones."""
    return {"python": platform.python_version(), **{name: _version(name) for name in packages}}


def code_version() -> str:
    """Return the commit of the running checkout, or the value of FLEXROS_COMMIT; "unknown" without either."""
    command = ["git", "-C", str(Path(__file__).parent), "rev-parse", "--short", "HEAD"]
    try:
        process = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - our own words
    except FileNotFoundError:
        return os.environ.get("FLEXROS_COMMIT", "unknown")
    return process.stdout.strip() or os.environ.get("FLEXROS_COMMIT", "unknown")


def machine() -> dict[str, object]:
    """Return processor, number of its cores, and operating system, to accompany measured times."""
    return {"processor": _processor(), "cores": os.cpu_count(), "system": platform.platform()}


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    """Return the name of the processor; on Linux from /proc/cpuinfo, since `platform` may not know it."""
    file = Path("/proc/cpuinfo")
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
