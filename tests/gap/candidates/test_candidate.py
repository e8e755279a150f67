"""Fitted parameters keep within the ranges of their effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import effects
from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.yielding_friction import BRISTLES
from flexros.gap.candidates.candidate import (
    Candidate,
    FreeParameter,
    below_nominal,
    distinct_locations,
    free_parameter,
    from_zero,
    list_candidates,
    name_of,
    own_numbers,
)
from flexros.gap.candidates.scales import Scales
from flexros.robot import load_robot

SIGNED = [
    (name, parameter)
    for name, effect in effects().items()
    for parameter, allowed in effect.ranges.items()
    if allowed.signed
]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("stiffness_error@body_1.ry", {"body_1.ry.stiffness"}),
        ("viscous_friction@motor_2", {"motor_2.viscous_friction"}),
        ("coulomb_friction@motor_1", set()),
    ],
)
def test_errors_of_a_number_stand_for_its_deviation_within_tolerance(name: str, expected: set[str]) -> None:
    """Viscous friction of -1.96 and a tolerated number of +2.00 Nm s/rad cancelled in a patch, and one was a cause."""
    robot = load_robot("elbow")
    among = {one.name: one for one in list_candidates(robot, Scales({}))}
    assert own_numbers((among[name],), robot) == expected


def test_negative_values_may_have_a_bound_of_their_own() -> None:
    free = free_parameter("relative", Range("relative", 0.01, 10.0, 6, signed=True, negative=0.9), 1.0)
    assert [float(free.decode(np.array(bound))) for bound in free.bounds] == pytest.approx([-0.9, 10.0])
    assert min(free.starts) == -0.9
    assert max(free.starts) > 0.9
    assert free_parameter("level", Range("torque", 0.01, 10.0, signed=True), 2.0).bounds == (-1.0, 1.0)


def test_positive_values_may_have_a_bound_of_their_own() -> None:
    free = free_parameter("relative", Range("relative", 0.01, 0.9, (-0.3,), signed=True, positive=0.0), 1.0)
    assert [float(free.decode(np.array(bound))) for bound in free.bounds] == pytest.approx([-0.9, 0.0])
    assert free.starts == (-0.3,)


@pytest.mark.parametrize(("name", "parameter"), SIGNED)
def test_effects_allow_the_bounds_of_their_ranges(name: str, parameter: str) -> None:
    effect = effects()[name]
    others = {"knee": 1e-3} if name == "nonlinear_stiffness" else {}
    free = free_parameter(parameter, effect.ranges[parameter], 1.0)
    for encoded in (*free.bounds, *map(free.encode, free.starts)):
        value = float(free.decode(np.array(encoded)))
        assert getattr(effect(**{**others, parameter: value}), parameter) == value


@pytest.mark.parametrize("signed", [False, True])
def test_numbers_of_the_fit_and_values_are_each_others_inverse(signed: bool) -> None:
    free = FreeParameter("level", 1e-3, 10.0, signed, (1.0,))
    for value in (1e-3, 0.7, 10.0, *((-4.0,) if signed else ())):
        assert float(free.decode(np.array(free.encode(value)))) == pytest.approx(value)
    low, high = free.bounds
    assert low < free.encode(0.7) < high


def test_ranges_are_in_the_units_of_the_log() -> None:
    free = free_parameter("level", Range("torque", 1e-3, 1.0, starts=3), 20.0)
    assert (free.low, free.high) == pytest.approx((0.02, 20.0))
    ratios = np.array(free.starts[1:]) / np.array(free.starts[:-1])
    np.testing.assert_allclose(ratios, 10.0)
    assert free.low < free.starts[0]
    assert free.starts[-1] < free.high


def test_starts_may_be_given_one_by_one() -> None:
    free = free_parameter("limit", Range("torque", 0.1, 1.0, starts=(0.5, 0.99)), 20.0)
    assert free.starts == pytest.approx((10.0, 19.8))


def test_signed_numbers_start_on_both_sides() -> None:
    starts = free_parameter("relative", Range("relative", 0.01, 1.0, starts=4, signed=True), 1.0).starts
    assert sorted(starts) == pytest.approx([-0.1, -0.01, 0.01, 0.1])


def test_candidate_are_all_effects_with_ranges_at_all_their_places_but_periodic_ones() -> None:
    robot = load_robot("elbow")
    found = list_candidates(robot, Scales({}))
    names = [one.name for one in found]
    assert len(set(names)) == len(names)
    assert {"coulomb_friction@motor_1", "coulomb_friction@motor_2", "payload_error@tool"} <= set(names)
    expected = {name for name, one in effects().items() if one.ranges and "order" not in one.ranges and not one.words}
    assert {one.effect.name for one in found} <= expected
    assert not {"torque_ripple", "transmission_error"} & {one.effect.name for one in found}


def test_the_typical_effect_of_a_candidate_is_at_one_of_its_starts() -> None:
    for one in list_candidates(load_robot("four_mass_linear"), Scales({})):
        placed = one.typical()
        assert placed.location == one.location
        for free in one.free:
            assert getattr(placed.effect, free.name) in free.starts
            assert getattr(placed.effect, free.name) != 0


def test_all_and_the_only_motor_are_one_place() -> None:
    effect = effects()["delay"]
    assert distinct_locations(effect, load_robot("four_mass_linear")) == ("all",)
    assert set(distinct_locations(effect, load_robot("elbow"))) == {"all", "motor_1", "motor_2"}


def test_a_candidate_at_all_acts_at_every_motor() -> None:
    robot, effect = load_robot("elbow"), effects()["delay"]
    assert [Candidate(effect, place, ()).motors(robot) for place in ("all", "motor_2")] == [[0, 1], [1]]


def test_hypotheses_are_named_by_effects_and_locations() -> None:
    pair = tuple(
        Candidate(effects()[name], location, ()) for name, location in (("backlash", "motor_1"), ("delay", "all"))
    )
    assert name_of(pair) == "backlash@motor_1 + delay@all"
    assert name_of(()) == "nothing"


def test_starts_are_all_combinations_or_belong_together() -> None:
    free = tuple(FreeParameter(name, -1.0, 1.0, signed=True, starts=(0.1, 0.2)) for name in "ab")
    candidate = Candidate(effects()["coulomb_friction"], "motor_1", free)
    assert candidate.starts() == [(0.1, 0.1), (0.1, 0.2), (0.2, 0.1), (0.2, 0.2)]
    assert replace(candidate, together=True).starts() == [(0.1, 0.1), (0.2, 0.2)]


def test_a_value_at_a_limit_of_the_search_is_no_finding_but_a_neutral_one_is() -> None:
    stribeck = next(
        one for one in list_candidates(load_robot("elbow"), Scales({})) if one.effect.name == "stribeck_friction"
    )
    usual = {free.name: float(free.decode(np.array(sum(free.bounds) / 2))) for free in stribeck.free}
    high = {free.name: float(free.decode(np.array(free.bounds[1]))) for free in stribeck.free}
    low = float(stribeck.free[0].decode(np.array(stribeck.free[0].bounds[0])))
    assert stribeck.at_limit(usual) == frozenset()
    assert stribeck.at_limit(high) == {free.name for free in stribeck.free}
    assert stribeck.at_limit({**usual, "extra": low}) == frozenset()


def test_a_parameter_that_moves_from_zero_on_is_nothing_there() -> None:
    usual = FreeParameter("level", 1e-6, 2.0, signed=False, starts=(0.1,))
    moved = from_zero(usual)
    assert moved.bounds == (0.0, 1.0)
    assert moved.decode(np.array([0.0, 0.5, 1.0])).tolist() == [0.0, 1.0, 2.0]
    assert Candidate(effects()["coulomb_friction"], "motor_1", (moved,)).neutral(moved) == 0.0
    assert from_zero(usual, high=0.5).bounds == (0.0, 1.0)
    assert from_zero(usual, high=0.5).decode(np.array(1.0)) == 0.5
    assert from_zero(moved) is moved


def test_a_nominal_number_of_which_nothing_is_left_is_a_finding() -> None:
    usual = FreeParameter("coefficient", 1e-6, 0.7, signed=False, starts=(0.1,))
    free = below_nominal(usual, 0.1 + 0.2)
    friction = Candidate(effects()["viscous_friction"], "motor_1", (free,))
    none_left, most = (float(free.decode(np.array(bound))) for bound in free.bounds)
    assert none_left == -(0.1 + 0.2)
    assert not friction.at_limit({"coefficient": none_left})
    assert friction.at_limit({"coefficient": most})


def test_a_parameter_of_the_shape_is_fixed_and_one_of_the_size_is_not() -> None:
    stribeck = next(
        one for one in list_candidates(load_robot("elbow"), Scales({})) if one.effect.name == "stribeck_friction"
    )
    fixed = stribeck.with_usual("velocity")
    assert fixed is not None
    assert "velocity" not in {free.name for free in fixed.free}
    assert dict(fixed.fixed)["velocity"] > 0
    assert stribeck.with_usual("extra") is None


def test_bristles_at_a_limit_are_none() -> None:
    """So stiff that the encoder does not show them, friction holds rigidly; of a usual stiffness it would yield."""
    friction = next(
        one for one in list_candidates(load_robot("elbow"), Scales({})) if one.effect.name == "coulomb_friction"
    )
    bristles = tuple(FreeParameter(name, 1.0, 1e6, signed=False, starts=(1e3,)) for name in BRISTLES)
    yielding = replace(friction, free=(*friction.free, *bristles))
    assert [yielding.with_usual(name) for name in BRISTLES] == [friction, friction]


@pytest.mark.parametrize(("effect", "part", "left"), [
    ("presliding_friction", "extra", {"level", "stiffness", "damping"}),
    ("presliding_friction", "damping", {"level", "extra", "velocity", "exponent", "stiffness"}),
    ("presliding_friction", "level", None),
    ("stribeck_friction", "extra", None),
    ("motor_inertia_error", "relative", None),
])  # fmt: skip
def test_a_part_of_a_law_goes_with_what_shapes_it_but_its_size_stays(
    effect: str, part: str, left: set[str] | None
) -> None:
    among = {one.name: one for one in list_candidates(load_robot("elbow"), Scales({}))}
    rest = among[f"{effect}@motor_1"].without_part(part)
    assert (None if rest is None else {free.name for free in rest.free}) == left


def test_a_saturation_vanishes_at_its_highest_limit() -> None:
    saturation = next(
        one for one in list_candidates(load_robot("elbow"), Scales({})) if one.effect.name == "torque_saturation"
    )
    (limit,) = saturation.free
    assert saturation.neutral(limit) == limit.bounds[1]


def test_a_mode_vanishes_with_a_light_part_at_the_tool_and_with_a_heavy_ground() -> None:
    """A light ground on the same frequency is soft: the whole arm would swing on it."""
    modes = {one.location: one for one in list_candidates(load_robot("e12"), Scales({})) if one.name[:5] == "extra"}
    limits = {
        place: next((free.bounds, mode.neutral(free)) for free in mode.free if free.name == "ratio")
        for place, mode in modes.items()
    }
    assert limits["base"][1] == limits["base"][0][1]
    assert limits["tool"][1] == limits["tool"][0][0]


def test_nominal_friction_may_be_far_too_large_in_logs_of_real_machines() -> None:
    robot = load_robot("elbow")
    nominal = robot.parameters["motor_1.viscous_friction"].value
    simulated, measured = (
        next(
            one.free[0]
            for one in list_candidates(robot, Scales({}), measured=real)
            if one.name == "viscous_friction@motor_1"
        )
        for real in (False, True)
    )
    assert not simulated.signed
    low, _ = (float(measured.decode(np.array(bound))) for bound in measured.bounds)
    assert low == pytest.approx(-nominal)
    assert measured.high >= simulated.high
    assert set(simulated.starts) < set(measured.starts)
    assert min(measured.starts) == pytest.approx(-0.9 * nominal)


def test_without_nominal_friction_there_is_nothing_to_take_away() -> None:
    (free, *_) = next(
        one.free
        for one in list_candidates(load_robot("two_mass"), Scales({}), measured=True)
        if one.effect.name == "viscous_friction"
    )
    assert not free.signed


def test_the_load_of_a_light_wrist_may_be_many_times_its_mass() -> None:
    among = {one.name: one for one in list_candidates(load_robot("elbow"), Scales({}))}
    wide = among["payload_error@tool"].widened("relative")
    assert wide is not None
    assert wide.free[0].high == pytest.approx(10 * among["payload_error@tool"].free[0].high)
    assert among["coulomb_friction@motor_1"].widened("level") is None


@pytest.mark.parametrize("scale", [0.01, 300.0])
def test_viscous_friction_is_sought_up_to_ten_times_the_largest_torque_over_speed(scale: float) -> None:
    """Of a joint that moves little for its torque, friction takes nearly all of it."""
    sizes = Scales({"torque": {"motor_1": scale}, "speed": {"motor_1": 1.0}})
    every = list_candidates(load_robot("two_mass"), sizes)
    found = next(one for one in every if one.name == "viscous_friction@motor_1")
    wide = found.widened("coefficient")
    assert found.free[0].high == pytest.approx(scale)
    assert wide is not None
    assert wide.free[0].high == pytest.approx(10 * scale)
    assert wide.widened("coefficient") is None


def test_a_torque_constant_may_be_several_times_too_small_but_never_below_zero() -> None:
    among = {one.name: one for one in list_candidates(load_robot("elbow"), Scales({}))}
    usual = among["torque_gain_error@motor_1"]
    wide = usual.widened("relative")
    assert wide is not None
    lowest, highest = (float(wide.free[0].decode(np.asarray(bound))) for bound in wide.free[0].bounds)
    assert (lowest, highest) == pytest.approx((-0.63, 9.0))
    assert usual.free[0].high == pytest.approx(0.9)
    assert wide.widened("relative") is None
