"""The experiment of a log, rebuilt from the scenario in its provenance."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.record.periodic_parts import periodic_parts

if TYPE_CHECKING:
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.scenario.experiment import Experiment


def recorded_experiment(log: Log) -> Experiment | None:
    """Prepare the scenario of a log, without noise and deviations of the plant.

    Returns:
        The experiment; None if the log has none, one of another version, or one whose robot is not on this machine.
    """
    from flexros.scenario.experiment import Experiment
    from flexros.scenario.scenario import Scenario

    given = log.provenance.get("scenario")
    if not isinstance(given, dict):
        return None
    try:
        return Experiment.prepare(Scenario.model_validate({**given, "noise": False, "plant": {}}))
    except (InputError, ValueError):
        return None


def with_recorded_parts(record: Record, log: Log) -> Record:
    """Add the multisines of a diagnosis experiment to the record of its log, as whole periods within the record.

    A record of another or unknown experiment is returned unchanged.
    """
    given = log.provenance.get("scenario")
    if not isinstance(given, dict) or not given.get("diagnosis"):
        return record
    experiment = recorded_experiment(log)
    if experiment is None:
        return record
    end = record.first + record.n_samples
    parts = (part.within(record.first, end) for part in periodic_parts(experiment.trajectory, record.sample_time))
    return replace(record, parts=tuple(part for part in parts if part is not None))
