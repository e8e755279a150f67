"""Short identification experiments for the tests of planning and running."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from flexros.identify.experiment.plan import ExperimentPlan
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import Scenario


def _scenario(**identification: object) -> Scenario:
    """Make a scenario on E12 whose experiments take 2.1 s each; the keys of `identification` replace those here."""
    given = {
        "positions": [[0.0, 0.3], [0.1, 0.4]],
        "blocks": 1,
        "periods": 2,
        "transient_periods": 1,
        "fade": 0.3,
        "settle": 0.1,
        "move": {"speed": 0.3, "acceleration": 0.3},
        "excitation": {"kind": "multisine", "period": 0.5, "lowest": 3.0, "highest": 40.0, "amplitude": 0.05},
    }
    return Scenario.model_validate(
        {
            "name": "mine",
            "robot": "e12",
            "feedforward": {"method": "flexible_joint"},
            "controller": {"kind": "pid", "kp": 1.35e5, "kd": 9000, "derivative_filter": 1e-3},
            "identification": {**given, **identification},
        }
    )


@pytest.fixture
def scenario_of() -> Callable[..., Scenario]:
    """Give a maker of scenarios, see `_scenario`."""
    return _scenario


@pytest.fixture
def plan_of() -> Callable[..., ExperimentPlan]:
    """Give a maker of plans of such scenarios."""
    return lambda **identification: plan_of_scenario(_scenario(**identification))
