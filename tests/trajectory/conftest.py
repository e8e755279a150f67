from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.errors import InputError

E12_START = np.array([2.146403786951, -0.354624247994])


@dataclass(frozen=True)
class TwoLinkArm:
    """Rigid two-link arm of 1 m and 1.2 m in the x-z plane, turning about +y, the second angle relative."""

    upper: float = 1.0
    fore: float = 1.2

    def forward(self, q: FloatArray) -> FloatArray:
        a, b = q[0], q[0] + q[1]
        return np.array(
            [self.upper * np.cos(a) + self.fore * np.cos(b), -self.upper * np.sin(a) - self.fore * np.sin(b)]
        )

    def jacobian(self, q: FloatArray) -> FloatArray:
        a, b = q[0], q[0] + q[1]
        second = np.array([-self.fore * np.sin(b), -self.fore * np.cos(b)])
        first = second + np.array([-self.upper * np.sin(a), -self.upper * np.cos(a)])
        return np.column_stack((first, second))

    def inverse_kinematics(self, target: FloatArray, near: FloatArray) -> FloatArray:
        distance = float(np.hypot(*target))
        cos_q2 = (distance**2 - self.upper**2 - self.fore**2) / (2.0 * self.upper * self.fore)
        if abs(cos_q2) > 1.0:
            raise InputError(f"the point is {distance:.5g} m away, the arm reaches 0.2 m to 2.2 m")
        q2 = np.copysign(np.arccos(cos_q2), near[1])
        bend = np.arctan2(self.fore * np.sin(q2), self.upper + self.fore * np.cos(q2))
        return np.array([np.arctan2(-target[1], target[0]) - bend, q2])

    def gamma(self) -> ca.Function:
        q = ca.SX.sym("q", 2)
        a, b = q[0], q[0] + q[1]
        z = ca.vertcat(self.upper * ca.cos(a) + self.fore * ca.cos(b), -self.upper * ca.sin(a) - self.fore * ca.sin(b))
        return ca.Function("gamma", [q], [z])


@pytest.fixture
def arm() -> TwoLinkArm:
    return TwoLinkArm()


@pytest.fixture
def start() -> FloatArray:
    """Tool position of E12 at its start pose (facts of Paper B)."""
    return E12_START.copy()
