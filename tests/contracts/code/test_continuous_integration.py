"""The script of all checks: its exit code is that of its steps, whatever its cleaning up does."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[3]


@pytest.mark.parametrize("code", [0, 3])
@pytest.mark.parametrize("work", ["true", "sleep 60 &"])
def test_cleaning_up_leaves_the_exit_code(tmp_path, code, work):
    before_steps, *_ = (CHECKOUT / ".ci" / "run").read_text().partition("\nstep ")
    script = tmp_path / ".ci" / "run"
    script.parent.mkdir()
    script.write_text(f"{before_steps}\n{work}\nexit {code}\n")
    assert subprocess.run(["bash", script], timeout=30, check=False).returncode == code
