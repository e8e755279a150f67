from __future__ import annotations

import os
import platform
from importlib.metadata import version

from flexros.provenance import machine, versions


def test_versions_are_those_of_the_installed_packages():
    found = versions()
    assert list(found) == ["python", "flexros", "casadi", "llvmlite", "numpy", "scipy"]
    assert (found["python"], found["numpy"]) == (platform.python_version(), version("numpy"))


def test_an_absent_package_is_said_to_be_absent():
    assert versions(("no-such-package",))["no-such-package"] == "not installed"


def test_machine_is_named():
    described = machine()
    assert set(described) == {"processor", "cores", "system"}
    assert described["cores"] == os.cpu_count()
    assert platform.machine() in str(described["system"])
