"""FlexROS: modelling, control, identification and gap diagnosis of flexible robot manipulators.

The names below are what most work needs; each is loaded when it is used first, so that `import flexros` stays fast.
The rooms behind them (`flexros.robot`, `flexros.identify`, ...) hold everything else.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.analysis.run_analysis import Analysis
    from flexros.benchmark.controllers import controller_names
    from flexros.benchmark.evaluate import BenchmarkResult
    from flexros.effects.patching.patched_robot import load_model
    from flexros.errors import FlexrosError, InputError, RunError
    from flexros.gap.measure_gap import MeasuredGap
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.result import IdentificationResult
    from flexros.logs.reader import read_log
    from flexros.logs.time_series import Log
    from flexros.logs.write_log import write_log
    from flexros.robot.linear.linearise import LinearModel
    from flexros.robot.robot import Robot, load_robot, robot_names
    from flexros.scenario.scenario import Scenario, load_scenario, scenario_names
    from flexros.workbench.controllers import BenchmarkResults, ControllerDesign, benchmark_controllers, design
    from flexros.workbench.diagnosis import Diagnosis, diagnose, measure_gap
    from flexros.workbench.identification import FrequencyResponses, frequency_responses, identify_robot
    from flexros.workbench.robots import linear_model
    from flexros.workbench.runs import Run, analyze, run

_WHERE = {
    "Analysis": "analysis.run_analysis",
    "BenchmarkResult": "benchmark.evaluate",
    "BenchmarkResults": "workbench.controllers",
    "ControllerDesign": "workbench.controllers",
    "Diagnosis": "workbench.diagnosis",
    "FlexrosError": "errors",
    "FrequencyResponse": "identify.frf.frequency_response",
    "FrequencyResponses": "workbench.identification",
    "IdentificationResult": "identify.result",
    "InputError": "errors",
    "LinearModel": "robot.linear.linearise",
    "Log": "logs.time_series",
    "MeasuredGap": "gap.measure_gap",
    "Robot": "robot.robot",
    "Run": "workbench.runs",
    "RunError": "errors",
    "Scenario": "scenario.scenario",
    "analyze": "workbench.runs",
    "benchmark_controllers": "workbench.controllers",
    "controller_names": "benchmark.controllers",
    "design": "workbench.controllers",
    "diagnose": "workbench.diagnosis",
    "frequency_responses": "workbench.identification",
    "identify_robot": "workbench.identification",
    "linear_model": "workbench.robots",
    "load_model": "effects.patching.patched_robot",
    "load_robot": "robot.robot",
    "load_scenario": "scenario.scenario",
    "measure_gap": "workbench.diagnosis",
    "read_log": "logs.reader",
    "robot_names": "robot.robot",
    "run": "workbench.runs",
    "scenario_names": "scenario.scenario",
    "write_log": "logs.write_log",
}
"""Module of each name, below this package."""

__all__ = [
    "Analysis",
    "BenchmarkResult",
    "BenchmarkResults",
    "ControllerDesign",
    "Diagnosis",
    "FlexrosError",
    "FrequencyResponse",
    "FrequencyResponses",
    "IdentificationResult",
    "InputError",
    "LinearModel",
    "Log",
    "MeasuredGap",
    "Robot",
    "Run",
    "RunError",
    "Scenario",
    "analyze",
    "benchmark_controllers",
    "controller_names",
    "design",
    "diagnose",
    "frequency_responses",
    "identify_robot",
    "linear_model",
    "load_model",
    "load_robot",
    "load_scenario",
    "measure_gap",
    "read_log",
    "robot_names",
    "run",
    "scenario_names",
    "write_log",
]


def __getattr__(name: str) -> object:
    where = _WHERE.get(name)
    if where is None:
        raise AttributeError(f"module 'flexros' has no attribute '{name}'; it offers {', '.join(__all__)}")
    value: object = getattr(import_module(f"{__name__}.{where}"), name)
    globals()[name] = value  # found at once from now on
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
