"""What results depend on beside their input: versions of packages, and the machine they were measured on."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

NUMERIC_PACKAGES = ("flexros", "casadi", "llvmlite", "numpy", "scipy")
"""Packages that the numbers of a run depend on."""


def versions(packages: tuple[str, ...] = NUMERIC_PACKAGES) -> dict[str, str]:
    """Look the versions of packages up.

    Args:
        packages: Names as on the package index.

    Returns:
        Version by name, that of Python first; "not installed" where a package is absent.
    """
    return {"python": platform.python_version(), **{name: _version(name) for name in packages}}


def code_version() -> str:
    """Name the commit of the checkout that runs, or what FLEXROS_COMMIT says; "unknown" where neither tells it."""
    command = ["git", "-C", str(Path(__file__).parent), "rev-parse", "--short", "HEAD"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - our own words
    except FileNotFoundError:
        return os.environ.get("FLEXROS_COMMIT", "unknown")
    return found.stdout.strip() or os.environ.get("FLEXROS_COMMIT", "unknown")


def machine() -> dict[str, object]:
    """Describe the machine for measured times.

    Returns:
        Processor, number of its cores, and operating system.
    """
    return {"processor": _processor(), "cores": os.cpu_count(), "system": platform.platform()}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    """Name the processor; Linux tells it in a file of its own, where `platform` may know nothing."""
    file = Path("/proc/cpuinfo")
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
