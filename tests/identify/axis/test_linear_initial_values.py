"""The two linear steps."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.axis import AxisStructure
from flexros.identify.axis.linear_initial_values import RigidStart, chain_of_masses, linear_start, rigid_start
from flexros.identify.axis.record import AxisRecord
from tests.identify.axis.recorded_axis import EFFECTS, axis_of, recorded_axis

SLIDE = recorded_axis(EFFECTS[1:], samples=8000)


@pytest.mark.parametrize("masses", [2, 3, 5])
def test_chain_has_the_given_frequencies(masses: int) -> None:
    rng = np.random.default_rng(masses)
    inertias, stiffnesses = rng.uniform(1, 10, masses), 1e4 * rng.uniform(1, 10, masses - 1)
    K = np.zeros((masses, masses))
    for place, k in enumerate(stiffnesses):
        K[place : place + 2, place : place + 2] += k * np.array([[1, -1], [-1, 1]])
    resonances, antiresonances = (
        np.sqrt(np.abs(np.sort(np.linalg.eigvals(K[first:, first:] / inertias[first:, None]).real))) / (2 * np.pi)
        for first in (0, 1)
    )
    chain = chain_of_masses(float(np.sum(inertias)), antiresonances, resonances[1:])
    np.testing.assert_allclose(chain[0], inertias, rtol=1e-6)
    np.testing.assert_allclose(chain[1], stiffnesses, rtol=1e-6)


@pytest.mark.parametrize(
    ("antiresonances", "resonances"), [([20], [10]), ([10, 12], [20, 30]), ([10], [20, 30]), ([], []), ([0], [1])]
)
def test_frequencies_that_no_chain_has_are_refused(antiresonances: list[float], resonances: list[float]) -> None:
    with pytest.raises(InputError, match=r"antiresonances are .* and resonances .* alternate, an antiresonance first"):
        chain_of_masses(1.0, antiresonances, resonances)


def test_number_of_frequencies_must_be_that_of_the_springs() -> None:
    rigid = RigidStart(10.0, 1.0, 1.0, 0.0)
    with pytest.raises(InputError, match="1 antiresonances are given, but a model of 3 masses has 2"):
        linear_start(AxisStructure(masses=3), rigid, [10], [20])


def test_rigid_axis_is_found_below_the_antiresonance() -> None:
    record = axis_of(SLIDE)
    rigid = rigid_start(record, 4.8, 0.02)
    assert rigid.inertia == pytest.approx(10.0, rel=0.02)
    assert rigid.viscous_friction == pytest.approx(15.0, rel=0.3)
    assert rigid.coulomb_friction == pytest.approx(20.0, rel=0.4)


def test_torque_of_the_wrong_sign_is_named() -> None:
    record = axis_of(SLIDE)
    wrong = AxisRecord("it", "position", record.sample_time, -record.torque, record.output, 0.0)
    with pytest.raises(InputError, match=r"it: a rigid axis of inertia -.*check joint, sign and unit"):
        rigid_start(wrong, 4.8, 0.02)


def test_short_record_is_named() -> None:
    record = axis_of(SLIDE)
    short = AxisRecord("it", "position", record.sample_time, record.torque[:500], record.output[:500], 0.0)
    with pytest.raises(InputError, match=r"it has 500 samples, but a regression below 4.8 Hz needs at least 832"):
        rigid_start(short, 4.8, 0.02)
