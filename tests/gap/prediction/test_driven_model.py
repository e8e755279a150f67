"""A joint whose torque is not known: its measured motion drives the model, and the other joints feel it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, place_effects
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.kinds.base import PlacedEffect
from flexros.errors import InputError
from flexros.gap.candidates.competitors import competitors
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.measure_gap import measure_gap
from flexros.gap.prediction.driven_model import driven_model
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.record.prescribed_motion import INERTIA as ENDLESS
from flexros.record.prescribed_motion import with_prescribed_motion
from flexros.record.record import Record
from tests.gap.rigid_arm import COULOMB, INERTIA, VISCOUS, arm, record_of_arm


@cache
def without_torque() -> Record:
    """A log of the arm whose second joint has the torque of nothing."""
    record = record_of_arm(imported=True)
    torque = record.torque.copy()
    torque[:, 1] = 0.1 * np.random.default_rng(1).standard_normal(len(torque))
    return with_prescribed_motion(replace(record, torque=torque), arm(), [1], "its torque is noise")


def nominal() -> RobotWithEffects:
    return place_effects(arm(), ())


def test_the_model_of_such_a_log_moves_its_joint_whatever_acts_there() -> None:
    rubbing = nominal().with_effects([PlacedEffect(CoulombFriction(level=1.0), name) for name in arm().joint_names])
    model = driven_model(rubbing, without_torque())
    assert model.robot.parameters["motor_2.inertia"].value == ENDLESS
    assert [law.location for law in model.laws] == ["motor_1"]
    assert "motor_2.inertia" not in tolerance_of(model.robot, {"inertia": 0.1}, without_torque().prescribed).names


def test_the_other_joint_feels_the_motion_as_it_was() -> None:
    """Its rotor and friction follow from its torque as where all torques are known."""
    record = without_torque()
    found = regress_torque(record, driven_model(nominal(), record), tolerance_of(arm(), {}))
    assert found is not None
    np.testing.assert_allclose(found.inertia, [INERTIA[0], 0.0], rtol=0.1)
    np.testing.assert_allclose(found.viscous_friction, [VISCOUS[0], 0.0], rtol=0.03)
    np.testing.assert_allclose(found.coulomb_friction, [COULOMB[0], 0.0], rtol=0.03)


def test_nothing_of_such_a_joint_is_weighed() -> None:
    record = without_torque()
    data = fit_data(record, driven_model(nominal(), record), DiagnosisSettings())
    assert np.isinf(data.spread[:, 1]).all()
    assert data.counted.sum() > 0.9 * data.record.n_samples
    assert data.values_of_motors[1] == 0


def test_no_effect_competes_at_such_a_joint() -> None:
    competing = competitors(arm(), SearchSettings(), (1,))
    assert competing.without == {"motor_2"}
    with pytest.raises(InputError, match="none of the effects coulomb_friction can act at motor_2"):
        competitors(arm(), SearchSettings(effects=("coulomb_friction",), joints=("motor_2",)), (1,))


def test_the_gap_is_that_of_the_other_joint() -> None:
    record, friction = without_torque(), PlacedEffect(CoulombFriction(level=float(COULOMB[0])), "motor_1")
    numbers = measure_gap(record, nominal(), repaired=nominal().with_effects([friction])).numbers
    assert numbers.closed_fraction is not None
    assert numbers.closed_fraction > 0.3


@pytest.mark.slow
def test_a_diagnosis_finds_what_the_other_joint_lacks() -> None:
    """What one log prescribes, the held-out one does."""
    search = SearchSettings(effects=("coulomb_friction", "viscous_friction"))
    settings = DiagnosisSettings(where=None, next_experiment=None, sensitivity=None, search=search)
    held = replace(record_of_arm(imported=True, seed=6), name="held")
    result = diagnose(without_torque(), arm(), holdout=held, settings=settings)
    causes = {f"{cause.effect}@{cause.location}": cause for cause in result.diagnosis.causes if cause.probability > 0.5}
    assert set(causes) == {"coulomb_friction@motor_1", "viscous_friction@motor_1"}
    assert causes["coulomb_friction@motor_1"].parameters["level"].value == pytest.approx(COULOMB[0], rel=0.03)
    assert causes["viscous_friction@motor_1"].parameters["coefficient"].value == pytest.approx(VISCOUS[0], rel=0.05)
    assert {row.joint for row in result.diagnosis.budget} == {"motor_1"}
    assert [gap.signal for gap in result.signals] == ["motor_1 position, 0.1 s ahead"]
    assert result.diagnosis.gap.closed_fraction is not None
    assert result.diagnosis.gap.closed_fraction > 0.95
    assert result.holdout is not None
    assert result.holdout.prescribed == (1,)
    warnings = result.diagnosis.warnings
    assert any("the measured motion of motor_2 drives the model" in text for text in warnings)
    assert any("held-out log" in text and "it does so in log" in text for text in warnings)
    assert any("The motion of motor_2 is prescribed" in text for text in result.limits)
