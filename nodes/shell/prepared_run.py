"""Experiment of a scenario, prepared once for all nodes of a process."""

from __future__ import annotations

from flexros.effects.patching.patched_robot import load_patched
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

_prepared: dict[tuple[str, ...], Experiment] = {}


def prepared_run(scenario: str) -> Experiment:
    """Prepare a scenario, or return the experiment already prepared for the same scenario and robot.

    Args:
        scenario: Built-in name, or path of a scenario file.

    Returns:
        The experiment; its costly parts are computed on first use.

    Raises:
        InputError: The scenario is invalid.
    """
    loaded = load_scenario(scenario)
    robots = [name for name in (loaded.robot, loaded.feedforward_model) if name is not None]
    key = loaded.digest(), *(load_patched(name).fingerprint for name in robots)
    if key not in _prepared:
        experiment = Experiment.prepare(loaded)
        _prepared.clear()  # one run at a time: the arrays of the previous one may be large
        _prepared[key] = experiment
    return _prepared[key]
