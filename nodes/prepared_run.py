"""The experiment behind a scenario, prepared once for all nodes of a process."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.config.scenario import load_scenario
from flexros.simulate.experiment import Experiment
from flexros.simulate.plant import Plant

if TYPE_CHECKING:
    from flexros.config.scenario import Scenario


_prepared: dict[str, Experiment] = {}


def prepared_run(scenario: str) -> Experiment:
    """Prepare a scenario, or give what another node of this process has prepared.

    Args:
        scenario: Shipped name, or path of a scenario file.

    Returns:
        The experiment; what is costly in it is made when first asked for.

    Raises:
        InputError: The scenario is not possible.
    """
    loaded: Scenario = load_scenario(scenario)
    key = loaded.digest()
    if key not in _prepared:
        experiment = Experiment.prepare(loaded)
        _prepared.clear()  # one run at a time: the arrays of the one before may be large
        _prepared[key] = experiment
    return _prepared[key]


def make_plant(experiment: Experiment) -> Plant:
    """Make the plant of an experiment at its start.

    Args:
        experiment: What is run.

    Returns:
        The plant, equal sample for sample to that of the in-process run.
    """
    scenario = experiment.scenario
    return Plant(
        experiment.plant,
        experiment.sample_time,
        experiment.start_state,
        seed=scenario.seed,
        noise=scenario.noise,
        disturbances=scenario.disturbances,
        substeps=scenario.substeps,
        torque=experiment.start_torque,
    )
