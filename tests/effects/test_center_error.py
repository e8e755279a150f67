"""Error of the centre of mass of a body."""

from __future__ import annotations

import pytest

from flexros.effects.center_error import CenterError
from flexros.gap.candidates.candidate import candidate_at
from flexros.gap.candidates.scales import Scales
from flexros.gap.diagnose import diagnose
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import settings_of
from tests.gap.rigid_arm import COULOMB, arm, record_of_arm
from tests.ur5e import ur5e


def test_the_centre_alone_moves() -> None:
    changed = CenterError(z=0.02).changed(arm(), "body_2")
    differing = {name for name, one in changed.parameters.items() if one.value != arm().parameters[name].value}
    assert differing == {"body_2.center_of_mass.z"}
    assert changed.parameters["body_2.center_of_mass.z"].value == pytest.approx(0.02)


def test_measured_torques_of_a_rigid_arm_under_gravity_show_it() -> None:
    sought = CenterError().sought_if_measured
    assert all(sought(arm(), body) for body in CenterError().locations(arm()))
    assert not sought(ur5e(), "body_2")  # turns about a vertical axis: an inertia alone
    assert sought(ur5e(), "body_3")
    assert not sought(load_robot("elbow"), "body_2")  # springs
    assert not sought(arm().with_values({"gravity.z": 0.0}), "body_2")
    assert not CenterError().sought(arm(), "body_2")


def test_it_moves_along_the_axes_that_a_log_shows_one_after_the_other() -> None:
    candidate = candidate_at(CenterError, "body_2", arm(), Scales({}))
    assert [free.name for free in candidate.free] == ["x", "z"]  # all joints turn about y
    starts = {tuple(start) for start in candidate.starts() if any(start)}
    assert starts == {(0.04, 0.0), (-0.04, 0.0), (0.0, 0.04), (0.0, -0.04)}


@pytest.mark.slow
def test_a_centre_beside_the_line_between_the_joints_is_found() -> None:
    """No tolerance of a zero holds it: a bias and a rotor had stood for it."""
    nominal = {name: arm().parameters[f"body_2.center_of_mass.{name}"].value for name in "xz"}
    offsets = {"x": -0.03, "z": -0.02}
    file = arm().with_values(
        {f"body_2.center_of_mass.{name}": nominal[name] + offset for name, offset in offsets.items()}
    )
    names = ("coulomb_friction", "viscous_friction", "torque_bias", "gravity_error", "inertia_error", "center_error")
    found = diagnose(record_of_arm(imported=True), file, settings=settings_of(*names)).diagnosis
    causes = {f"{one.effect}@{one.location}": one.parameters for one in found.causes}
    friction = {f"{law}_friction@motor_{k}" for law in ("coulomb", "viscous") for k in (1, 2)}
    assert set(causes) == {"center_error@body_2", *friction}
    x, z = (causes["center_error@body_2"][name] for name in "xz")
    assert z.value == pytest.approx(-offsets["z"], abs=0.002)
    assert x.value == pytest.approx(-offsets["x"], abs=2 * x.std)  # that of the file has a tolerance, beside its mass
    assert causes["coulomb_friction@motor_2"]["level"].value == pytest.approx(COULOMB[1], rel=0.02)
    (number,) = [one for one in found.model_numbers if one.name == "body_2.center_of_mass.z"]
    assert (number.nominal, number.value) == pytest.approx((-0.02, 0.0), abs=0.002)
