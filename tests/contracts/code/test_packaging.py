"""Content of a wheel, which works without the checkout. The two forms of colcon build are checked by .ci/run."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from configparser import ConfigParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

pytestmark = pytest.mark.slow

CHECKOUT = Path(__file__).parents[3]
PARTS = ("flexros", "nodes", "msgs_config", "resource", "setup.py", "setup.cfg", "pyproject.toml", "package.xml")

LOAD_ALL_DATA = """
import sys
from importlib.metadata import entry_points
import flexros
from flexros.config.location import data_folder
from flexros.scenario.scenario import load_scenario
from flexros.robot import load_robot, robot_names
here = sys.argv[1]
assert flexros.__file__.startswith(here), flexros.__file__
folder = data_folder("msgs_config")
assert str(folder) == here + "/share/flexros/msgs_config", folder
from pathlib import Path
scenarios = sorted((Path(flexros.__file__).parent / "scenario" / "library").glob("*.yaml"))
assert scenarios and robot_names()
for name in robot_names():
    load_robot(name)
for path in scenarios:
    load_scenario(path.stem)
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build a wheel from a copy of the checkout."""
    source = tmp_path_factory.mktemp("source")
    for part in PARTS:
        path = CHECKOUT / part
        if path.is_dir():
            shutil.copytree(path, source / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(path, source / part)
    (source / "flexros_nodes").symlink_to("nodes")
    target = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    run = subprocess.run([*pip, "--wheel-dir", target, source], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return next(target.glob("*.whl"))


@pytest.fixture(scope="module")
def content(wheel: Path) -> set[str]:
    """List the files of the wheel."""
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_every_file_of_the_packages_is_in_the_wheel(content: set[str]) -> None:
    files = {
        f"{name}/{path.relative_to(CHECKOUT / folder)}"
        for name, folder in (("flexros", "flexros"), ("flexros_nodes", "nodes"))
        for path in (CHECKOUT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and path.parent != CHECKOUT / "nodes" / "launch"
    }
    assert files <= content


def test_shared_files_are_in_the_wheel(content: set[str]) -> None:
    shared = {name.split(".data/data/")[1] for name in content if ".data/data/" in name}
    expected = {f"share/flexros/msgs_config/{path.name}" for path in (CHECKOUT / "msgs_config").glob("*.yaml")}
    expected |= {f"share/flexros/launch/{path.name}" for path in (CHECKOUT / "nodes" / "launch").glob("*.launch.py")}
    assert expected
    assert shared == {*expected, "share/flexros/package.xml", "share/ament_index/resource_index/packages/flexros"}


def test_pip_puts_no_command_but_flexros_on_the_path(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        entry_points = next(name for name in archive.namelist() if name.endswith("entry_points.txt"))
        text = archive.read(entry_points).decode()
    scripts = ConfigParser()
    scripts.read_string(text)
    assert list(scripts["console_scripts"]) == ["flexros"]


def test_installed_wheel_finds_all_its_data(wheel: Path, tmp_path: Path) -> None:
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", tmp_path]
    subprocess.run([*pip, wheel], check=True, capture_output=True)
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, sys.argv[1])\n{LOAD_ALL_DATA}", tmp_path]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert run.returncode == 0, run.stderr


def test_versions_agree(wheel: Path) -> None:
    package = ElementTree.parse(CHECKOUT / "package.xml").findtext("version")
    assert package == wheel.name.split("-")[1]
    assert f"## {package}" in (CHECKOUT / "CHANGELOG.md").read_text(encoding="utf-8")
