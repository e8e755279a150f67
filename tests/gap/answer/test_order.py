"""The order of effects in an answer."""

from __future__ import annotations

from flexros.gap.answer.order import in_order, largest_part
from flexros.gap.schema import BudgetShare, Cause, CauseParameter, Step, Waterfall


def cause(effect: str, probability: float) -> Cause:
    return Cause(effect=effect, location="motor_1", probability=probability, parameters={}, closed_fraction=None)


def share(effect: str, last: float) -> BudgetShare:
    names = {"joint": "motor_1", "class": "friction", "effect": effect, "location": "motor_1"}
    return BudgetShare.model_validate({**names, "share_first": None, "share_last": last, "interval": None})


def both(effect: str, first: float | None, last: float) -> BudgetShare:
    return share(effect, last).model_copy(update={"share_first": first})


def test_the_largest_part_closes_as_much_first_as_last() -> None:
    """A gain that made up for the other effects would close two thirds, of 4 % at its joint."""
    budget = (both("stiffness_error", -1.1, 0.64), both("rotor_inertia", None, 0.6), both("delay", 0.52, 0.53))
    largest, closed = largest_part(budget)
    assert largest is budget[2]
    assert closed == 0.52


def test_effects_that_close_the_gap_only_together_have_no_largest_part() -> None:
    assert largest_part((both("delay", -0.2, 0.6), both("backlash", 0.4, 0.001))) == (None, 0.0)


def waterfall(**closed: float) -> Waterfall:
    steps = tuple(Step(effect=effect, location="motor_1", share=part) for effect, part in closed.items())
    return Waterfall(joint="motor_1", before=1.0, steps=steps, left=0.0)


def ordered(shares: tuple[BudgetShare, ...], steps: Waterfall, **probabilities: float) -> list[str]:
    causes = [cause(effect, probability) for effect, probability in probabilities.items()]
    return [one.effect for one in in_order(causes, shares, (steps,))]


def test_what_closes_most_comes_before_what_is_more_probable() -> None:
    shares = share("hysteresis", 0.6), share("backlash", 0.2)
    assert ordered(shares, waterfall(hysteresis=0.6, backlash=0.2), backlash=0.99, hysteresis=0.7) == [
        "hysteresis", "backlash",
    ]  # fmt: skip


def test_of_effects_that_stand_for_each_other_the_first_of_the_waterfall_leads() -> None:
    shares = share("delay", 0.0), share("actuator_lag", 0.001)
    assert ordered(shares, waterfall(delay=0.9, actuator_lag=0.0), actuator_lag=0.9, delay=0.8)[0] == "delay"


def test_what_closes_nothing_or_makes_it_worse_is_sorted_by_probability() -> None:
    shares = share("delay", -0.3), share("backlash", 0.001)
    assert ordered(shares, waterfall(delay=-0.3), backlash=0.6, hysteresis=0.7, delay=0.9) == [
        "delay", "hysteresis", "backlash",
    ]  # fmt: skip


def sized(effect: str, **stds: float) -> Cause:
    parameters = {name: CauseParameter(value=1.0, std=std, unit="1") for name, std in stds.items()}
    return cause(effect, 1.0).model_copy(update={"parameters": parameters})


def test_a_size_that_is_not_clear_does_not_come_first() -> None:
    """Of the demonstration: an inertia of +162 % (±146) closed more removed last, friction 70 % added first."""
    inertia, friction = sized("motor_inertia_error", relative=0.9), sized("coulomb_friction", level=0.1)
    budget = both("motor_inertia_error", 0.32, 0.26), both("coulomb_friction", 0.7, 0.07)
    steps = waterfall(coulomb_friction=0.7, motor_inertia_error=0.2)
    assert in_order((inertia, friction), budget, (steps,)) == (friction, inertia)
    assert largest_part(budget, (inertia, friction)) == (budget[1], 0.07)


def test_a_clear_shape_is_no_clear_size() -> None:
    """The order of a ripple is known well long before its amplitude is."""
    ripple, friction = sized("torque_ripple", amplitude=0.9, order=0.001), sized("coulomb_friction", level=0.1)
    budget = both("torque_ripple", 0.3, 0.3), both("coulomb_friction", 0.2, 0.2)
    assert in_order((ripple, friction), budget, ()) == (friction, ripple)


def test_clear_sizes_are_in_the_order_of_the_waterfall() -> None:
    """It is that of the mean of added first and removed last."""
    gain, friction = sized("torque_gain_error", relative=0.1), sized("coulomb_friction", level=0.1)
    budget = both("torque_gain_error", -1.1, 0.64), both("coulomb_friction", 0.5, 0.1)
    assert in_order((gain, friction), budget, ()) == (friction, gain)


def test_what_closes_nothing_does_not_come_before_a_part_of_the_gap() -> None:
    inertia, friction = sized("motor_inertia_error", relative=0.9), sized("coulomb_friction", level=0.1)
    budget = both("motor_inertia_error", 0.9, 0.9), both("coulomb_friction", 0.001, 0.001)
    assert in_order((friction, inertia), budget, ()) == (inertia, friction)
