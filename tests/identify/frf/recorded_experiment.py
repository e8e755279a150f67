"""A short identification experiment on E12."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexros.identify.experiment.plan import ExperimentPlan
from flexros.logs.time_series import JointSeries, Log
from flexros.robot import Robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification_plan import plan_of_log
from flexros.scenario.scenario import Scenario


@dataclass(frozen=True)
class Recorded:
    """A log, its plan and its robot."""

    log: Log
    plan: ExperimentPlan
    robot: Robot


def run(effects: tuple[str, ...] = (), **identification: object) -> Recorded:
    """Run E12 in two positions with two blocks each; the keys of `identification` replace those here."""
    given = {
        "positions": [[0.0, 0.3], [0.1, 0.5]],
        "blocks": 2,
        "periods": 2,
        "transient_periods": 3,
        "fade": 0.3,
        "settle": 0.1,
        "move": {"speed": 0.3, "acceleration": 0.3},
        "excitation": {"kind": "multisine", "period": 1.0, "lowest": 3.0, "highest": 40.0, "amplitude": 0.05},
    }
    scenario = Scenario.model_validate(
        {
            "name": "mine",
            "robot": "e12",
            "feedforward": {"method": "flexible_joint"},
            "controller": {"kind": "pid", "kp": 1.35e5, "kd": 9000, "derivative_filter": 1e-3},
            "identification": {**given, **identification},
            "plant": {"values": {}, "effects": effects},
        }
    )
    experiment = Experiment.prepare(scenario)
    log = closed_loop(experiment)
    return Recorded(log, plan_of_log(log), experiment.nominal)


def cut(log: Log, keep: np.ndarray | slice) -> Log:
    """Keep some samples of a log of motor signals."""

    def rows(series: JointSeries | None) -> JointSeries | None:
        if series is None:
            return None
        parts = {name: getattr(series, name) for name in ("position", "velocity", "effort")}
        kept = {name: None if part is None else part[keep] for name, part in parts.items()}
        return JointSeries(series.stamp[keep], series.names, **kept)

    states = rows(log.joint_states)
    assert states is not None
    return Log(states, rows(log.joint_commands), rows(log.joint_reference), provenance=log.provenance)
