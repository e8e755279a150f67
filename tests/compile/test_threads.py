"""Symbolic work in several threads, as a diagnosis does it."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

BUILD = """
import random, threading
import casadi as ca

def build(seed):
    draw = random.Random(seed)
    for _ in range(1000):
        x = ca.SX.sym("x", 3)
        y = sum(ca.sin(x[k]) * (draw.randint(1, 40) / 8 + 0.1) for k in range(3))
        for _ in range(10):
            y = y * (draw.randint(1, 9) / 4) + ca.SX(draw.randint(0, 20) / 3)

threads = [threading.Thread(target=build, args=(seed,)) for seed in range(4)]
for one in threads:
    one.start()
for one in threads:
    one.join()
"""


def test_expressions_may_be_built_side_by_side() -> None:
    """CasADi 3.7 and later end with a segmentation fault: threads count references to shared constants at once."""
    assert subprocess.run([sys.executable, "-c", BUILD], timeout=120).returncode == 0
