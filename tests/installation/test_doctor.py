"""Checks of the installation, each with what is amiss."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from flexros.installation import folders, machine, packages, ros
from flexros.installation.doctor import examine, healthy
from flexros.installation.finding import Finding


def test_python_out_of_range_is_broken() -> None:
    assert packages.check_python((3, 9)).state == "broken"
    assert "3.10" in packages.check_python((3, 9)).remedy
    assert packages.check_python((3, 12)).state == "ok"


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "importlib.metadata.requires", lambda _name: ["numpy>=1", "no-such-package>=2", "x; extra == 'a'"]
    )
    finding = packages.check_packages()
    assert finding.state == "broken"
    assert finding.remedy == "pip install no-such-package"
    assert finding.facts["numpy"]


def test_a_package_of_another_version_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.metadata.requires", lambda _name: ["numpy>=1", "casadi>=3.6.7,<3.6.8,>=99"])
    finding = packages.check_packages()
    assert finding.state == "broken"
    assert finding.remedy == "pip install 'casadi<3.6.8,>=3.6.7,>=99'"


def test_without_ros_runs_are_in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ros, "find_spec", lambda _name: None)
    finding = ros.check_ros({})
    assert finding.state == "limited"
    assert finding.facts["found"] is False
    assert "jazzy" in ros.check_ros({"ROS_DISTRO": "jazzy"}).text
    assert ros.check_middleware(finding, {}) is None


def test_ros_that_cannot_be_loaded_is_broken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "rclpy.py").write_text("raise ImportError('librcl.so: not found')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    finding = ros.check_ros({**os.environ, "PYTHONPATH": str(tmp_path)})
    assert finding.state == "broken"
    assert "librcl.so: not found" in finding.text


def test_ros_is_found_with_its_middleware(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    package = tmp_path / "rclpy"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "utilities.py").write_text("def get_rmw_implementation_identifier(): return 'rmw_cyclonedds_cpp'\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    finding = ros.check_ros({**os.environ, "PYTHONPATH": str(tmp_path), "ROS_DISTRO": "humble"})
    assert finding.state == "limited"
    assert finding.facts["origin"] == "sourced"
    middleware = ros.check_middleware(finding, {})
    assert middleware is not None
    assert middleware.facts["name"] == "rmw_cyclonedds_cpp"


def test_small_or_missing_shared_memory_is_limited(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert machine.check_shared_memory(tmp_path / "none").state == "limited"
    monkeypatch.setattr(machine, "LEAST_SHARED", 1e18)
    assert "shm-size" in machine.check_shared_memory(tmp_path).remedy


@pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="priorities of Linux")
@pytest.mark.parametrize(("program", "state"), [("pass", "ok"), ("raise SystemExit(1)", "limited")])
def test_real_time_rights_are_tried(monkeypatch: pytest.MonkeyPatch, program: str, state: str) -> None:
    monkeypatch.setattr(machine, "_PRIORITY", program)
    finding = machine.check_real_time()
    assert finding.state == state
    assert finding.facts["permitted"] is (state == "ok")


def test_a_governor_that_saves_power_is_limited(tmp_path: Path) -> None:
    for core, governor in enumerate(("powersave", "performance")):
        folder = tmp_path / f"cpu{core}" / "cpufreq"
        folder.mkdir(parents=True)
        (folder / "scaling_governor").write_text(f"{governor}\n")
    finding = machine.check_processor(tmp_path)
    assert finding.state == "limited"
    assert finding.facts["governors"] == ["performance", "powersave"]
    assert machine.check_processor(tmp_path / "none").state == "ok"


def test_cache_home_and_temporary_files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("FLEXROS_CACHE", str(tmp_path / "cache"))
    assert folders.check_cache().facts == {"folder": str(tmp_path / "cache" / "objects"), "usable": True}
    monkeypatch.setenv("FLEXROS_CACHE", "off")
    assert folders.check_cache().state == "limited"
    assert folders.check_home({}).state == "limited"
    assert folders.check_home({"HOME": str(tmp_path / "none")}).state == "limited"
    assert folders.check_home({"HOME": str(tmp_path)}).state == "ok"
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert folders.check_temporary().facts["folder"] == str(tmp_path)


@pytest.mark.slow
def test_this_installation_works() -> None:
    findings = examine(dict(os.environ))
    assert healthy(findings), [finding for finding in findings if finding.state == "broken"]
    assert {"Python", "packages", "ROS 2", "shared memory", "real-time rights", "cache"} <= {f.name for f in findings}
    assert not healthy((*findings, Finding("x", "broken", "")))
