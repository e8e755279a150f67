"""A short experiment on E12 for the tests of repetitions."""

from __future__ import annotations

import pytest

from flexros.scenario.scenario import Scenario, load_scenario


@pytest.fixture(scope="session")
def short_experiment() -> Scenario:
    changes = {
        "identification.positions": [[0.0, 0.3], [0.3, 1.0]],
        "identification.blocks": 2,
        "identification.transient_periods": 1,
    }
    return load_scenario("identify_e12").with_values(changes)
