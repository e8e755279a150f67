"""A load that an arm lacks, by a regression of its torques."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.torques.missing_load import load_beside
from flexros.gap.settings import TorqueStartSettings
from flexros.robot import load_robot


@pytest.mark.parametrize(("share", "found"), [(0.3, True), (9.0, True), (11.0, False), (-0.3, False)])
def test_a_load_is_none_where_no_arm_carries_it(share: float, found: bool) -> None:
    elbow = load_robot("elbow")
    moved = sum(elbow.parameters[f"body_{k}.mass"].value for k in (1, 2))
    mass = share * moved
    loaded: Any = SimpleNamespace(load=np.array([mass, 0.1 * mass, 0.0, 0.0]), left=np.array([0.01, 0.01]))
    without: Any = SimpleNamespace(left=np.array([1.0, 1.0]))
    load = load_beside(lambda *_, **__: loaded, elbow, Tolerance(), without, (), TorqueStartSettings())
    assert (load is not None) == found
