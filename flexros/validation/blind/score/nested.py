"""Nested effects: the model of one holds the other as a special case, so either name is right."""

from __future__ import annotations

NESTED: tuple[frozenset[str], ...] = (
    frozenset({"presliding_friction", "coulomb_friction"}),
    frozenset({"presliding_friction", "stribeck_friction"}),
    frozenset({"nonlinear_stiffness", "stiffness_error"}),
    frozenset({"friction_drift", "coulomb_friction"}),
    frozenset({"friction_drift", "viscous_friction"}),
)
"""Pairs of which one holds the other as a special case (contract of section 8)."""


def same(truth: str, named: str, nested: bool) -> bool:
    """Whether a name is right.

    Args:
        truth: Effect that is hidden.
        named: Effect that was named.
        nested: Whether an effect that holds the other as a special case is right as well.
    """
    return truth == named or (nested and frozenset({truth, named}) in NESTED)


def same_place(robot: str, truth: str, named: str) -> bool:
    """Whether a location is right; on a robot with one motor "all" is that motor."""
    one_motor = robot.startswith(("four_mass", "two_mass", "emps"))
    return truth == named or (one_motor and {truth, named} == {"all", "motor_1"})
