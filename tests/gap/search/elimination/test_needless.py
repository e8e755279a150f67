"""Needless effects: how clear torques show a size, and from which size on an effect is one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.checked_log import checked_log
from flexros.gap.search.elimination import needless, reduce
from flexros.gap.search.elimination.needless import _nothing
from flexros.gap.settings import DiagnosisSettings
from tests.gap.search.elimination.named_fits import (
    COULOMB,
    INERTIA,
    LEFT_OUT,
    VISCOUS,
    Fit,
    Search,
    plain_rules,
    size_of,
)
from tests.gap.servo_logs import servo_arm, servo_log


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    plain_rules(monkeypatch, reduce, needless)


@pytest.mark.slow
def test_a_rotor_is_none_beside_the_inertia_of_its_bodies_and_not_beside_that_of_a_large_arm() -> None:
    """The search for rotors goes up to 10 kg m2, of which a thousandth is a rotor at a wrist."""
    robot = servo_arm(rotors=False)
    data = SimpleNamespace(record=checked_log(servo_log(robot=servo_arm), robot, name="log"))
    candidates = list_candidates(robot, scales_of_motors(robot, data.record), measured=True)
    rotor = next(one for one in candidates if one.name == "rotor_inertia@motor_2")
    null = SimpleNamespace(model=SimpleNamespace(robot=robot))
    search: Any = SimpleNamespace(data=data, null=null, settings=DiagnosisSettings())
    inertia = 0.02 * 0.3 + 0.3 * 0.1**2
    assert _nothing(search, rotor, rotor.free[0]) == pytest.approx(1e-3 * inertia)


@pytest.mark.parametrize(("size", "kept"), [(0.05, False), (0.07, True), (-0.05, False), (-0.07, True)])
def test_an_inertia_is_wrong_from_twice_its_tolerance_on(
    size: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = {COULOMB: size_of(1.0, 0.1), INERTIA: size_of(size, 1e-4)}
    monkeypatch.setattr(needless, "parameters_of", lambda fit, _: [{"size": sizes[name]} for name in fit.kept])
    search: Any = Search({frozenset({COULOMB}): 2000.0}, {COULOMB: 900.0, INERTIA: 1.0}, (COULOMB, INERTIA))
    found = reduce.reduced(search, Fit((COULOMB, INERTIA), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert (INERTIA in found.names) is kept


@pytest.mark.parametrize(("mass", "kept"), [(0.09, False), (0.11, True)])
def test_a_load_is_one_from_a_small_share_of_all_that_moves(
    mass: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However clear its mass and place are: 1.7 g at an arm of 15 kg were 2.6 deviations."""
    sizes = {COULOMB: {"size": size_of(1.0, 0.1)}, LEFT_OUT: {"mass": size_of(mass, 1e-4), "x": size_of(0.3, 0.01)}}
    monkeypatch.setattr(needless, "parameters_of", lambda fit, _: [sizes[name] for name in fit.kept])
    monkeypatch.setattr(needless, "moved_mass", lambda _: 20.0)
    search: Any = Search({frozenset({COULOMB}): 2000.0}, {COULOMB: 900.0, LEFT_OUT: 1.0}, (COULOMB, LEFT_OUT))
    begin = Fit((COULOMB, LEFT_OUT), 2000.0, free=("size", "mass", "x"))
    found = reduce.reduced(search, begin, [], 0.2)  # type: ignore[arg-type]
    assert (LEFT_OUT in found.names) is kept


@pytest.mark.parametrize("little", [(1e-5, 1e-9), (0.5, 0.0)], ids=["size zero", "size that changes nothing"])
def test_an_effect_without_a_size_is_left_out_though_its_deviation_is_small(
    little: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = {COULOMB: size_of(1.0, 0.1), VISCOUS: size_of(*little)}
    monkeypatch.setattr(needless, "parameters_of", lambda fit, _: [{"size": sizes[name]} for name in fit.kept])
    search: Any = Search({frozenset({COULOMB}): 2000.0}, {COULOMB: 900.0, VISCOUS: 1.0}, (COULOMB, VISCOUS))
    found = reduce.reduced(search, Fit((COULOMB, VISCOUS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {COULOMB}
