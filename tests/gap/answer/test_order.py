"""The order of effects in an answer."""

from __future__ import annotations

from flexros.gap.answer.order import in_order, largest_part
from flexros.gap.schema import BudgetShare, Cause, Step, Waterfall


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
