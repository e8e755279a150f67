"""Error of the inertia of a body."""

from __future__ import annotations

import pytest

from flexros.effects.inertia_error import InertiaError
from flexros.gap.candidates.candidate import candidate_at
from flexros.gap.candidates.scales import Scales
from flexros.gap.diagnose import diagnose
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import settings_of
from tests.gap.rigid_arm import VISCOUS, arm, record_of_arm
from tests.ur5e import ur5e


def test_the_inertia_alone_is_scaled() -> None:
    changed = InertiaError(relative=-0.75).changed(arm(), "body_2")
    differing = {name for name, one in changed.parameters.items() if one.value != arm().parameters[name].value}
    assert differing == {"body_2.inertia.xx", "body_2.inertia.yy", "body_2.inertia.zz"}
    assert changed.parameters["body_2.inertia.yy"].value == pytest.approx(0.01)


def test_its_places_are_bodies_that_move_and_have_an_inertia() -> None:
    assert "body_8" not in InertiaError().locations(ur5e())  # a frame
    assert InertiaError().locations(load_robot("elbow")) == ("body_1", "body_2")


def test_measured_torques_of_a_rigid_arm_show_it_where_no_motor_inertia_does_the_same() -> None:
    sought = InertiaError().sought_if_measured
    driven = arm().with_values({"motor_1.inertia": 0.8})
    assert [sought(arm(), body) for body in ("body_1", "body_2")] == [True, True]
    assert [sought(driven, body) for body in ("body_1", "body_2")] == [False, True]
    assert not sought(load_robot("elbow"), "body_2")  # springs
    assert not InertiaError().sought(arm(), "body_2")


def test_more_inertia_is_a_rotor_where_the_motor_has_none() -> None:
    driven = arm().with_values({"motor_2.inertia": 0.3})
    assert InertiaError().fitted(driven, "body_2")["relative"].positive is None
    (free,) = candidate_at(InertiaError, "body_2", arm(), Scales({})).free
    assert free.bounds == (-0.1, 0.0)
    assert max(free.starts) < 0


@pytest.mark.slow
def test_an_inertia_about_the_joint_in_place_of_that_about_the_centre_is_found() -> None:
    """Neither bodies that are far off nor a wrong gain or weight stand for it."""
    about_joint = 0.04 + 3 * 0.15**2
    file = arm().with_values({"body_2.inertia.yy": about_joint, "body_2.inertia.zz": about_joint})
    names = ("coulomb_friction", "viscous_friction", "torque_gain_error", "gravity_error", "inertia_error")
    found = diagnose(record_of_arm(imported=True), file, settings=settings_of(*names))
    causes = {f"{one.effect}@{one.location}": one.parameters for one in found.diagnosis.causes}
    friction = {f"{law}_friction@motor_{k}" for law in ("coulomb", "viscous") for k in (1, 2)}
    assert set(causes) == {"inertia_error@body_2", *friction}
    assert causes["inertia_error@body_2"]["relative"].value == pytest.approx(0.04 / about_joint - 1, abs=0.02)
    assert causes["viscous_friction@motor_2"]["coefficient"].value == pytest.approx(VISCOUS[1], rel=0.02)
