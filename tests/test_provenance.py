from __future__ import annotations

import os
import platform
import re
from importlib.metadata import version

from flexros import provenance
from flexros.provenance import code_version, machine, versions


def test_versions_are_those_of_the_installed_packages():
    found = versions()
    assert list(found) == ["python", "flexros", "casadi", "llvmlite", "numpy", "scipy"]
    assert (found["python"], found["numpy"]) == (platform.python_version(), version("numpy"))


def test_a_missing_package_is_reported():
    assert versions(("no-such-package",))["no-such-package"] == "not installed"


def test_machine_is_named():
    described = machine()
    assert set(described) == {"processor", "cores", "system"}
    assert described["cores"] == os.cpu_count()
    assert platform.machine() in str(described["system"])


def test_code_of_a_checkout_is_its_commit(monkeypatch):
    monkeypatch.setenv("FLEXROS_COMMIT", "abc")
    found = code_version()
    assert found == "abc" or re.fullmatch("[0-9a-f]{7,}", found)


def test_commit_outside_a_checkout_is_that_of_the_environment(monkeypatch, tmp_path):
    monkeypatch.setattr(provenance, "__file__", str(tmp_path / "provenance.py"))
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert code_version() == "unknown"
    monkeypatch.setenv("FLEXROS_COMMIT", "abc")
    assert code_version() == "abc"
    monkeypatch.setenv("PATH", "")
    assert code_version() == "abc"
