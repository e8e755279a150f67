"""Spring laws and their inverses."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.robot.spring import Spring

PIECES = {"knots": [0.01, 0.03], "slopes": [10.0, 40.0, 25.0]}
LAWS = [
    ({"stiffness": 50.0}, 50.0),
    ({"piecewise_linear": PIECES}, 1.2),
    ({"cubic": {"linear": 20.0, "cubic": 3e4}}, 0.8),
]


@pytest.mark.parametrize(("law", "scale"), LAWS)
def test_deflection_is_the_inverse_of_the_force(law: dict[str, object], scale: float) -> None:
    spring, d = Spring.model_validate(law), casadi.SX.sym("d")
    back = casadi.Function("back", [d], [spring.deflection(spring.force(d, scale), scale)])
    for deflection in (-0.08, -0.02, -0.004, 0.0, 0.005, 0.012, 0.03, 0.2):
        assert float(back(deflection)) == pytest.approx(deflection, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(
    "law",
    [
        {"stiffness": 0.0},
        {"piecewise_linear": {"knots": [0.01], "slopes": [5.0, 0.0]}},
        {"cubic": {"linear": 0, "cubic": 1}},
    ],
)
def test_laws_without_stiffness_have_none(law: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="zero stiffness"):
        Spring.model_validate(law).deflection(casadi.SX.sym("f"), 1.0)


def test_energy_is_the_integral_of_the_force() -> None:
    d = casadi.SX.sym("d")
    for law, scale in LAWS:
        spring = Spring.model_validate(law)
        slope = casadi.Function("slope", [d], [casadi.jacobian(spring.energy(d, scale), d), spring.force(d, scale)])
        found = np.array([[float(part) for part in slope(at)] for at in (-0.05, 0.02, 0.07)])
        assert found[:, 0] == pytest.approx(found[:, 1], rel=1e-9)
