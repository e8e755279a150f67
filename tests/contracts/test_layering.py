"""One direction: nodes -> flexros, never back; and within flexros no room below imports one above it."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
MODULES = sorted((CHECKOUT / "flexros").rglob("*.py"))
ROS = ("rclpy", "rosidl_runtime_py", "rosidl_parser", "launch", "launch_ros", "rosbag2_py", "ament_index_python")

ABOVE = {
    **dict.fromkeys(("compile", "control", "effects", "feedforward", "robot", "trajectory"), ("identify", "simulate")),
    "identify": ("simulate",),
    "logs": ("identify", "simulate"),
    "simulate": ("analysis",),
}
"""Rooms that a room must not import, beside `campaigns` and `cli`, which none of these may."""

IMPORT_ALL_WITHOUT_ROS = """
import importlib, importlib.abc, json, pkgutil, sys
class Blocker(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        room = name.split(".")[0]
        if room in %r or room.endswith("_msgs") or room.endswith("_interfaces") or room == "flexros_nodes":
            raise ImportError(f"{name} is blocked")
sys.meta_path.insert(0, Blocker())
import flexros
modules = pkgutil.walk_packages(flexros.__path__, "flexros.")
names = ["flexros"] + [module.name for module in modules if not module.name.endswith("__main__")]
for name in names:
    importlib.import_module(name)
print(json.dumps(names))
"""


def test_flexros_imports_without_ros() -> None:
    program = IMPORT_ALL_WITHOUT_ROS % (ROS,)
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=CHECKOUT, check=False)
    assert run.returncode == 0, run.stderr
    assert len(json.loads(run.stdout.splitlines()[-1])) > 10


def imported(path: Path) -> set[str]:
    """Names of all modules that a file imports, at its top or within functions."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
    return names


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(CHECKOUT)))
def test_module_imports_neither_ros_nor_nodes(path: Path) -> None:
    rooms = {name.split(".")[0] for name in imported(path)}
    assert not {room for room in rooms if room in {*ROS, "flexros_nodes", "nodes"} or room.endswith("_msgs")}


@pytest.mark.parametrize("room", sorted(ABOVE))
def test_room_imports_none_above_it(room: str) -> None:
    forbidden = tuple(f"flexros.{above}." for above in (*ABOVE[room], "campaigns", "cli"))
    found = {
        (str(path.relative_to(CHECKOUT)), name)
        for path in (CHECKOUT / "flexros" / room).rglob("*.py")
        for name in imported(path)
        if f"{name}.".startswith(forbidden)
    }
    assert not found
