"""The experiment that a log was recorded by, made again from the scenario in its provenance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.gap.where.periodic import PeriodicPart, periodic_parts

if TYPE_CHECKING:
    from flexros.logs.time_series import Log
    from flexros.simulate.experiment import Experiment


def recorded_experiment(log: Log) -> Experiment | None:
    """Prepare the scenario of a log, without noise and with nothing hidden in the plant.

    Args:
        log: The log.

    Returns:
        The experiment; None where the log names none, one of another version, or one whose robot is not on this
        machine.
    """
    from flexros.config.scenario import Scenario
    from flexros.simulate.experiment import Experiment

    given = log.provenance.get("scenario")
    if not isinstance(given, dict):
        return None
    try:
        return Experiment.prepare(Scenario.model_validate({**given, "noise": False, "plant": {}}))
    except (InputError, ValueError):
        return None


def recorded_parts(log: Log, sample_time: float, first: int, end: int) -> tuple[PeriodicPart, ...]:
    """Find the multisines of a diagnosis experiment in its log.

    Args:
        log: The log.
        sample_time: Time between two samples [s].
        first: First sample that is looked at, counted from the beginning of the experiment.
        end: Sample behind the last one.

    Returns:
        Their whole periods, counted from the first sample on; nothing where the experiment is another or not known.
    """
    given = log.provenance.get("scenario")
    if not isinstance(given, dict) or not given.get("diagnosis"):
        return ()
    experiment = recorded_experiment(log)
    if experiment is None:
        return ()
    parts = (part.within(first, end) for part in periodic_parts(experiment.trajectory, sample_time))
    return tuple(part for part in parts if part is not None)
