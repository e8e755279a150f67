"""Bring the virtual environment `.venv` of a checkout to a wanted state; called by the Makefile, needs only Python.

`python3 environment.py test` makes `.venv` if it is missing, broken or half-made, and installs FlexROS with the extras
named. ROS 2 comes from the sourced Jazzy where there is one, else from the wheels of the extra `ros`; where those
cannot be had, everything else is installed and a sentence says what that means. A stamp keeps repeated calls from
installing again.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

CHECKOUT = Path(__file__).resolve().parent
VENV = CHECKOUT / ".venv"
PYTHON = VENV / "bin" / "python"
STAMP = VENV / "flexros-installed.json"
UNFINISHED = VENV / "flexros-unfinished"
IN_PROCESS = "everything but the nodes works, and the demo will run in-process"


class Ros(NamedTuple):
    """Where rclpy is to come from: `source` is "sourced", "wheels" or "none", `reason` says why not from the wheels."""

    source: str
    reason: str


def ros_source(environment: dict[str, str], rclpy_importable: bool, system: str, machine: str, libc: str) -> Ros:
    """Choose where rclpy comes from.

    Args:
        environment: Environment variables; ROS_DISTRO names the sourced distribution.
        rclpy_importable: Whether the Python that makes the environment can import rclpy.
        system: Operating system, as in `platform.system()`.
        machine: Processor, as in `platform.machine()`.
        libc: Name and version of the C library, e.g. "glibc 2.36".

    Returns:
        The choice with its reason.
    """
    distribution = environment.get("ROS_DISTRO", "")
    if distribution == "jazzy" and rclpy_importable:
        return Ros("sourced", "a ROS 2 Jazzy is sourced")
    where = f"{system} {machine} {libc}".strip()
    name, _, version = libc.partition(" ")
    numbers = tuple(int(part) for part in version.split(".")[:2] if part.isdigit())
    if (system, machine, name) != ("Linux", "x86_64", "glibc") or numbers < (2, 28):
        return Ros("none", f"there are ROS 2 wheels for Linux x86_64 with glibc 2.28 or newer, not for {where}")
    return Ros("wheels", "")


def wanted(extras: set[str], ros: Ros) -> dict[str, object]:
    """Describe the state the environment shall have; two equal descriptions need no new installation."""
    package = b"".join((CHECKOUT / name).read_bytes() for name in ("setup.py", "setup.cfg", "pyproject.toml"))
    return {
        "checkout": str(CHECKOUT),
        "python": sys.version,
        "ros": ros.source,
        "package": hashlib.sha256(package).hexdigest(),
        "extras": sorted(extras),
    }


def installed() -> dict[str, object]:
    """Read the state the environment has, empty if it must be made anew."""
    if UNFINISHED.exists() or not STAMP.exists():
        return {}
    if subprocess.run([PYTHON, "-c", "import pip"], check=False, capture_output=True).returncode != 0:
        return {}
    state: dict[str, object] = json.loads(STAMP.read_text(encoding="utf-8"))
    return state


def pip_install(extras: set[str], *constraints: str) -> bool:
    """Install the checkout with extras into the environment, telling whether pip succeeded."""
    target = f"{CHECKOUT}[{','.join(sorted(extras))}]" if extras else str(CHECKOUT)
    command = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input"]
    quiet = {**os.environ, "PYTHONWARNINGS": "ignore"}  # setuptools warns of every editable installation
    return subprocess.run([*command, "--editable", target, *constraints], check=False, env=quiet).returncode == 0


def main(extras: set[str]) -> int:
    """Bring the environment to the state that holds these extras.

    Args:
        extras: Extras of setup.py besides `ros`, e.g. {"test"}.

    Returns:
        Exit code: 0 when the environment is ready, else 1.
    """
    rclpy = subprocess.run([sys.executable, "-c", "import rclpy"], check=False, capture_output=True, cwd="/")
    libc = " ".join(platform.libc_ver())
    ros = ros_source(dict(os.environ), rclpy.returncode == 0, platform.system(), platform.machine(), libc)
    before = installed()
    base = wanted(set(), ros)
    if {**before, "extras": [], "package": ""} != {**base, "package": ""}:
        before = {}
        make(ros)
    extras = extras | set(before.get("extras", [])) if before else extras
    goal = wanted(extras, ros)
    if before == goal:
        return 0
    return install(goal, extras, ros)


def make(ros: Ros) -> None:
    """Make the environment anew, seeing the system's packages when those hold the ROS 2 to be used."""
    shutil.rmtree(VENV, ignore_errors=True)
    print("Making the virtual environment .venv", flush=True)
    options = ["--system-site-packages"] if ros.source == "sourced" else []
    if subprocess.run([sys.executable, "-m", "venv", *options, VENV], check=False).returncode != 0:
        shutil.rmtree(VENV, ignore_errors=True)
        sys.exit(
            f"{sys.executable} cannot make a virtual environment; install its module venv (python3-venv) and try again"
        )


def install(goal: dict[str, object], extras: set[str], ros: Ros) -> int:
    """Install FlexROS with its extras and write the stamp; if aborted, a marker makes the next call start anew."""
    UNFINISHED.touch()
    # The pip of Python 3.10 needs ten minutes to resolve the extra `test`, a current one 20 seconds.
    upgrade = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--upgrade", "pip>=24.1"]
    print("Installing FlexROS into .venv (about a minute, only once)", flush=True)
    # Message packages of a sourced Jazzy are compiled against NumPy 1 and cannot be imported with NumPy 2.
    constraints = ("numpy<2",) if ros.source == "sourced" else ()
    subprocess.run(upgrade, check=False)
    complete = ros.source == "wheels" and pip_install({*extras, "ros"})
    if not complete and not pip_install(extras, *constraints):
        print(
            "pip could not install FlexROS: see its message above; check the network, then try again",
            file=sys.stderr,
        )
        return 1
    if ros.source == "none":
        print(f"No ROS 2 here: {ros.reason}; {IN_PROCESS}.")
    if ros.source == "wheels" and not complete:
        print(f"The ROS 2 wheels could not be installed, see above: {IN_PROCESS}. The next call tries again.")
        goal = {**goal, "extras": [], "package": "without the ROS 2 wheels"}
    STAMP.write_text(json.dumps(goal), encoding="utf-8")
    UNFINISHED.unlink()
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(set(sys.argv[1:])))
    except KeyboardInterrupt:
        sys.exit(130)
