"""The whole identification procedure: design, run, frequency responses, fit, report."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from flexros.errors import InputError
from flexros.identify.frf.files.netcdf import save_responses
from flexros.identify.frf.positions import estimate_responses
from flexros.identify.frf.settings import FrfSettings
from flexros.identify.graybox.search import SearchSettings
from flexros.identify.report.files import make_folder, write_identification
from flexros.identify.report.record import identification_record
from flexros.identify.result import ExperimentFacts, fit_responses
from flexros.logs.reader import read_log
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification import LONGEST, design_identification, unknown_names
from flexros.scenario.identification_plan import plan_of_log

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from numpy.typing import ArrayLike

    from flexros.identify.design.experiment_design import DesignSettings
    from flexros.identify.result import IdentificationResult
    from flexros.robot import Robot
    from flexros.scenario.identification import DesignedExperiment
    from flexros.scenario.scenario import Scenario
    from flexros.scenario.transports import RunResult

SCENARIO, LOG, RESPONSES = "experiment.yaml", "log", "frf.nc"
"""Names of scenario, log and frequency responses in the folder of the procedure."""

DESIGN, ESTIMATE, FIT = "designing the experiment", "estimating frequency responses", "fitting"
"""Steps that are reported to `progress`."""


@dataclass(frozen=True, eq=False)
class Identification:
    """Results of the procedure.

    Attributes:
        experiment: The designed experiment.
        run: The outcome of the run.
        result: The fitted parameters and their verdicts.
    """

    experiment: DesignedExperiment
    run: RunResult
    result: IdentificationResult

    def as_dict(self) -> dict[str, Any]:
        """Return all figures for JSON."""
        return {**identification_record(self.result), "run": self.run.as_dict()}


def identify_robot(
    robot: Robot,
    template: Scenario,
    folder: Path,
    run: Callable[[DesignedExperiment, Path], RunResult],
    *,
    unknown: Sequence[str] = (),
    design: DesignSettings | None = None,
    ranges: ArrayLike | None = None,
    longest: float = LONGEST,
    settings: SearchSettings | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Identification:
    """Design an experiment, run it, estimate frequency responses, fit the parameters, and report.

    Args:
        robot: The nominal robot.
        template: Excitation and controller, see `template_scenario`.
        folder: Folder for scenario, log, responses, identified robot and report; made where it is missing.
        run: Runs the experiment and writes its log into the given folder, for instance
            `lambda experiment, log: run_direct(experiment.scenario, log)`, see `flexros.scenario.transports`.
        unknown: Names of the unknown parameters; default: see `unknown_names`.
        design: How many positions, out of how many; default: see `design_identification`.
        ranges: Smallest and largest coordinate of each gear [rad or m], shape (M, 2); default: about the home pose.
        longest: Robot time up to which transient periods are added [s].
        settings: How to search for the parameters; default: `SearchSettings()`.
        progress: Called with the current step (`DESIGN`, `ESTIMATE` or `FIT`), the amount done and the amount in all;
            the run reports its own progress.

    Returns:
        Experiment, run and result; the files are in the folder.

    Raises:
        InputError: The folder holds a log already, or something given is not possible.
        RunError: The run aborted, or the model cannot be evaluated at any start.
    """
    settings = settings or SearchSettings()
    if (folder / LOG).exists():
        raise InputError(f"the log folder {folder / LOG} exists already; give another folder", "out")
    names = unknown_names(robot, unknown)
    settings.check(robot, names)
    make_folder(folder)

    def report(step: str, done: int, total: int) -> None:
        if progress is not None:
            progress(step, done, total)

    report(DESIGN, 0, 1)
    experiment = design_identification(
        robot,
        names,
        template,
        folder / SCENARIO,
        settings=design,
        ranges=ranges,
        longest=longest,
        progress=lambda _, done, total: report(DESIGN, done, total),
    )
    outcome = run(experiment, folder / LOG)
    outcome.require_complete()
    log = read_log(folder / LOG)
    plan = plan_of_log(log)
    report(ESTIMATE, 0, len(plan.positions))
    responses = estimate_responses(log, plan, FrfSettings(), robot, progress=partial(report, ESTIMATE))
    save_responses(responses, folder / RESPONSES)
    report(FIT, 0, settings.starts)
    result = fit_responses(
        robot,
        responses,
        names,
        settings,
        design=experiment.design,
        facts=ExperimentFacts.of(plan, LOG, outcome.transport),
        truth=_truth(Experiment.prepare(experiment.scenario).plant, robot, names),
        warnings=_lowered(experiment),
        provenance=log.provenance,
        progress=lambda done: report(FIT, done, settings.starts),
    )
    write_identification(result, folder, f"experiment {experiment.scenario.name}")
    return Identification(experiment, outcome, result)


def _lowered(experiment: DesignedExperiment) -> tuple[str, ...]:
    """Return the warning of lowered amplitudes, if they were."""
    factor = experiment.amplitude_factor
    if factor == 1:
        return ()
    return (f"Amplitudes were lowered to {100 * factor:.3g} % of the template's because of the torque limits.",)


def _truth(plant: Robot, nominal: Robot, names: Sequence[str]) -> dict[str, float]:
    """Return the values of the simulated robot, without those of another unit there (factors on other laws)."""
    known = plant.parameters
    return {name: known[name].value for name in names if known[name].unit == nominal.parameters[name].unit}
