"""Commands of a controller that is much faster than its recorder: noted as they are, and not as they are held."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.measure_gap import measure_gap
from flexros.record.record import Record
from flexros.record.shifted_torque import HELD
from tests.gap.rigid_arm import INERTIA, VISCOUS, T, arm, motion

NOISE = 1e-5
"""Noise of the encoders [rad]."""


def model() -> RobotWithEffects:
    """Return the model of the arm with its rotors and viscous friction."""
    numbers = {"inertia": INERTIA, "viscous_friction": VISCOUS}
    return RobotWithEffects(
        arm().with_values({f"motor_{1 + i}.{name}": sizes[i] for name, sizes in numbers.items() for i in range(2)}), ()
    )


def log(*, thinned: bool) -> Record:
    """Return a log of the arm, with commands as they are at their stamps, or as they are held from there on."""
    q, v, a = motion()
    plant = arm().model
    torque = np.asarray(plant.arm_inverse_dynamics(q.T, v.T, a.T, plant.parameter_values), dtype=float).T
    torque += INERTIA * a + VISCOUS * v
    held = 0.5 * (torque + np.vstack([torque[1:], torque[-1:]]))
    noted = torque if thinned else held
    position = q + NOISE * np.random.default_rng(3).standard_normal(q.shape)
    return Record("log", T, position, noted, np.ones(len(q), dtype=bool), noted=noted, torque_shift=HELD, imported=True)


@pytest.mark.slow
@pytest.mark.parametrize("thinned", [True, False])
def test_thinned_commands_act_at_their_stamps_and_held_ones_behind_them(thinned: bool) -> None:
    found = measure_gap(log(thinned=thinned), model(), tolerance={"torque": 0.005})
    assert any("as values at their stamps" in text for text in found.warnings) == thinned
    assert not found.significant
