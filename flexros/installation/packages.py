"""Versions of Python, FlexROS and the packages it needs."""

from __future__ import annotations

import platform
import sys
from importlib import metadata
from importlib.util import find_spec

from packaging.requirements import Requirement

from flexros.installation.finding import Finding

OLDEST, NEWEST = (3, 10), (3, 13)
"""First and last version of Python that FlexROS supports."""
OPTIONAL = {"mujoco": "export to and comparison with MuJoCo", "cma": "tuning of controllers", "slycot": "H-infinity"}
"""Packages of extras, and what they are for."""


def check_python(version: tuple[int, int] = sys.version_info[:2]) -> Finding:
    """Check the version of Python.

    Args:
        version: Major and minor version.
    """
    text = f"Python {platform.python_version()} at {sys.executable}"
    facts = {"version": platform.python_version(), "executable": sys.executable}
    if OLDEST <= version <= NEWEST:
        return Finding("Python", "ok", text, facts=facts)
    span = f"{OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]}"
    return Finding("Python", "broken", text, f"FlexROS needs {span}; make an environment with one of them", facts)


def check_packages() -> Finding:
    """Check that the packages are there that the installed FlexROS states, in these versions, and list them."""
    try:
        required = metadata.requires("flexros") or []
        own = metadata.version("flexros")
    except metadata.PackageNotFoundError:
        text = "FlexROS runs from a folder and is not installed: commands of other packages and ROS nodes are not found"
        return Finding("packages", "limited", text, "pip install -e CHECKOUT")
    needed = [one for one in map(Requirement, required) if one.marker is None]
    versions = {one.name: _version(one.name) for one in needed}
    facts = {"flexros": own, **versions}
    missing = [one.name for one in needed if not versions[one.name]]
    if missing:
        text = f"FlexROS {own} without {', '.join(missing)}"
        return Finding("packages", "broken", text, f"pip install {' '.join(missing)}", facts)
    other = [one for one in needed if not one.specifier.contains(versions[one.name], prereleases=True)]
    if other:
        text = f"FlexROS {own} with {', '.join(f'{one.name} {versions[one.name]}' for one in other)}"
        wanted = " ".join(f"'{one.name}{one.specifier}'" for one in other)
        return Finding("packages", "broken", text, f"pip install {wanted}", facts)
    numeric = ", ".join(f"{name} {versions[name]}" for name in ("numpy", "casadi", "llvmlite") if name in versions)
    return Finding("packages", "ok", f"FlexROS {own} with {len(versions)} packages, among them {numeric}", facts=facts)


def check_extras() -> Finding:
    """List optional packages; none of them is needed."""
    there = {name: find_spec(name) is not None for name in OPTIONAL}
    missing = [f"{name} ({OPTIONAL[name]})" for name, found in there.items() if not found]
    if not missing:
        return Finding("extras", "ok", f"{', '.join(there)} are there", facts=there)
    remedy = "where these are wanted: pip install 'flexros[mujoco,design]'"
    return Finding("extras", "limited", f"without {', '.join(missing)}", remedy, there)


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
