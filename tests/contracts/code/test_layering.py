"""The library works without ROS; import-linter (make lint) checks which room may import which."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[3]
ROS = ("rclpy", "rosidl_runtime_py", "rosidl_parser", "launch", "launch_ros", "rosbag2_py", "ament_index_python")

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


@pytest.mark.slow
def test_flexros_imports_without_ros() -> None:
    program = IMPORT_ALL_WITHOUT_ROS % (ROS,)
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=CHECKOUT, check=False)
    assert run.returncode == 0, run.stderr
    assert len(json.loads(run.stdout.splitlines()[-1])) > 10
