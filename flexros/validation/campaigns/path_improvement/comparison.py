"""Path errors of the real robot with nominal and with identified feedforward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.path_error import path_error
from flexros.errors import InputError, unknown_name
from flexros.identify.frf.positions import estimate_responses
from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.identified_robot import write_identified_robot
from flexros.identify.graybox.search import SearchSettings, search
from flexros.robot.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification import unknown_names
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from flexros.robot.parameters import Parameter
    from flexros.scenario.scenario import Scenario


@dataclass(frozen=True)
class PathImprovement:
    """Largest path errors of the real robot in one motion.

    Attributes:
        motion: Name of the scenario.
        method: Its feedforward.
        nominal: With the nominal model [m].
        identified: With the identified model [m].
        true: With the true model, the best that identification could reach [m].
    """

    motion: str
    method: str
    nominal: float
    identified: float
    true: float

    @property
    def factor(self) -> float:
        """How many times smaller the error is with the identified model."""
        return self.nominal / self.identified


@dataclass(frozen=True)
class Improvement:
    """An identification and the path errors with it.

    Attributes:
        parameters: By name: nominal, true and identified value [SI] and relative standard deviation.
        paths: Path errors, one per motion.
    """

    parameters: Mapping[str, tuple[float, float, float, float]]
    paths: tuple[PathImprovement, ...]


def identify_and_compare(
    experiment: Scenario, real: Mapping[str, float], motions: Sequence[str], file: Path
) -> Improvement:
    """Identify a robot whose parameters differ from the nominal ones, then move it with three models.

    Args:
        experiment: Identification experiment on the nominal robot.
        real: Parameters of the real robot that differ: name -> value over nominal value.
        motions: Built-in scenarios of the same robot that are run with both feedforwards.
        file: File of the identified robot; it is written, and the motions read it.

    Returns:
        Identified values and path errors.

    Raises:
        InputError: A parameter is unknown, or a motion is one of another robot.
        RunError: A run became unstable.
    """
    nominal = load_robot(experiment.robot)
    true = _true_values(nominal.parameters, real)
    on_real = experiment.with_values({"plant.values": true})
    log = closed_loop(Experiment.prepare(on_real))
    responses = estimate_responses(log, plan_of_scenario(on_real), robot=nominal)
    names = unknown_names(nominal)
    search_result = search(nominal, responses, names, SearchSettings(starts=4))
    covariance = parameter_covariance(search_result.problem, search_result.fit)
    write_identified_robot(file, nominal, search_result.fit, covariance, f"experiment {experiment.name}")
    rows = zip(names, search_result.fit.values.tolist(), covariance.relative.tolist(), strict=True)
    return Improvement(
        parameters={
            name: (nominal.parameters[name].value, true.get(name, nominal.parameters[name].value), value, relative)
            for name, value, relative in rows
        },
        paths=tuple(_compare(load_scenario(name), experiment.robot, true, file) for name in motions),
    )


def _true_values(nominal: Mapping[str, Parameter], real: Mapping[str, float]) -> dict[str, float]:
    values = {}
    for name, factor in real.items():
        if name not in nominal:
            raise unknown_name("parameter of the real robot", name, nominal)
        values[name] = factor * nominal[name].value
    return values


def _compare(motion: Scenario, robot: str, true: dict[str, float], file: Path) -> PathImprovement:
    """Move the real robot with feedforward from the nominal, the identified and the true model."""
    if motion.robot != robot:
        raise InputError(f"scenario {motion.name} moves robot {motion.robot}, but {robot} was identified")
    on_real = motion.with_values({"plant.values": true})
    return PathImprovement(
        motion=motion.name,
        method=motion.feedforward.method,
        nominal=_largest_error(on_real),
        identified=_largest_error(on_real.with_values({"robot": str(file)})),
        true=_largest_error(motion.with_values({"model.values": true})),
    )


def _largest_error(scenario: Scenario) -> float:
    log = closed_loop(Experiment.prepare(scenario))
    assert log.tool_pose is not None
    assert log.tool_reference is not None
    return float(np.max(path_error(log.tool_pose, log.tool_reference).distance))
