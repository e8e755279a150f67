"""Controllers and plants as python-control objects, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.control.linear_controller import linear_controller
from flexros.control.state_space import StateSpace
from flexros.errors import InputError

if TYPE_CHECKING:
    import control

    from flexros.control.base import AbstractControlLaw
    from flexros.control.context import LoopContext
    from flexros.control.design.plants import SampledPlants


def law_from_control(system: Any, sample_time: float, **settings: Any) -> StateSpace:
    """Return a control law from a python-control system, from position errors to torques.

    A continuous system is sampled with the bilinear transform.

    Args:
        system: StateSpace or TransferFunction, one input per measured element and one output per motor.
        sample_time: Sample time of the loop [s].
        settings: Further settings of the law, e.g. inputs.

    Raises:
        InputError: A discrete system has another sample time.
    """
    import control  # here, because it loads slowly

    given = control.ss(system)
    if given.isctime(strict=True):
        given = control.c2d(given, sample_time, method="tustin")
    elif given.dt not in (True, None) and abs(given.dt - sample_time) > 1e-9 * sample_time:
        raise InputError(
            f"the system has the sample time {given.dt:g} s, but the loop {sample_time:g} s; sample it again"
        )
    return StateSpace.model_validate(
        {
            "A": np.asarray(given.A),
            "B": np.asarray(given.B),
            "C": np.asarray(given.C) if given.nstates else [[] for _ in range(given.noutputs)],
            "D": np.asarray(given.D),
            "matrices_sample_time": sample_time,
            **settings,
        }
    )


def law_to_control(law: AbstractControlLaw, context: LoopContext) -> control.StateSpace:
    """Return a control law about rest as a discrete python-control system from measurements, negated, to torques."""
    import control  # here, because it loads slowly

    linear = linear_controller(law, context)
    return control.ss(
        linear.state_step, -linear.state_measured, linear.from_state, -linear.from_measured, context.sample_time
    )


def plant_to_control(plants: SampledPlants, number: int = 0) -> control.StateSpace:
    """Return one sampled plant as a python-control system from commands to measurements."""
    import control  # here, because it loads slowly

    C = plants.C[number]
    direct = np.zeros((len(C), plants.B.shape[-1]))
    return control.ss(plants.A[number], plants.B[number], C, direct, plants.sample_time)
