"""Gear torque as function of deflection: linear, piecewise linear, or cubic."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import casadi as ca

if TYPE_CHECKING:
    from collections.abc import Mapping

GearLaw = Literal["linear", "piecewise", "cubic"]

PARAMETERS: dict[GearLaw, dict[str, str]] = {
    "linear": {},
    "piecewise": {"gear_stiffening": "1", "gear_knee": "rad"},
    "cubic": {"gear_doubling": "rad"},
}
"""Parameters of each law in addition to gear_stiffness, with the unit for a rotary axis."""


def gear_torque(law: GearLaw, deflection: ca.SX, values: Mapping[str, ca.SX]) -> ca.SX:
    """Evaluate the gear law.

    With stiffness k near zero, deflection d, knee c, stiffening s and doubling deflection b:

        linear     k d
        piecewise  k d for |d| <= c, sign(d) (k c + s k (|d| - c)) beyond
        cubic      k d (1 + (d / b)^2)

    Args:
        law: Name of the law.
        deflection: Motor minus arm [rad or m], SX.
        values: Symbols of the parameters by name.

    Returns:
        Torque on the arm [Nm or N], SX.
    """
    k = values["gear_stiffness"]
    if law == "piecewise":
        knee = values["gear_knee"]
        beyond = ca.fmax(deflection - knee, 0) + ca.fmin(deflection + knee, 0)
        return k * (deflection + (values["gear_stiffening"] - 1) * beyond)
    if law == "cubic":
        return k * deflection * (1 + (deflection / values["gear_doubling"]) ** 2)
    return k * deflection
