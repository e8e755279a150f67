"""What no law explains, on a machine with friction and a force that no effect of the library describes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import ClassVar

import casadi as ca
import numpy as np
import pytest
import yaml

from flexros.effects import PlacedLaw, RobotWithEffects, effects, parse_effect, place_effects
from flexros.effects.kinds.base import Stage
from flexros.effects.kinds.motor_law import AbstractMotorTorque, MotorState
from flexros.effects.torque_bias import TorqueBias
from flexros.effects.torque_drift import TorqueDrift
from flexros.gap.diagnose import diagnose
from flexros.gap.result import DiagnosisResult
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data
from flexros.robot.symbolic.kinematics import Value
from flexros.simulate.plant import Plant
from tests.gap.rigid_arm import ARM, INERTIA

pytestmark = pytest.mark.slow

T, NOISE = 0.005, 2e-5
LONG, SHORT = 4000, 2200
"""Samples of a log in which a load grows and falls again, and of the others."""

RIVALS = (
    *("coulomb_friction", "viscous_friction", "stribeck_friction", "friction_drift", "friction_curve"),
    *("torque_bias", "torque_gain_error", "motor_inertia_error", "torque_curve", "torque_drift"),
    "friction_over_position",
)
"""Laws and curves that may stand for each other; for the hump of friction all effects compete."""
ALL = DiagnosisSettings(where=None, next_experiment=None)
FEW = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=RIVALS))
FIRST = ("coulomb_friction@motor_1:level=6", "viscous_friction@motor_1:coefficient=4")
SECOND = "coulomb_friction@motor_2:level=2"
FASTER = 2.0
"""How much faster the motion is where it is to repeat between the knots of a curve over time [1]."""


def friction_hump(motor: MotorState) -> ca.SX:
    """Friction that is 1 Nm higher at one speed."""
    speed = motor.speed
    return -ca.tanh(speed / 0.01) * ca.exp(-(((ca.fabs(speed) - 0.6) / 0.2) ** 2))


def cable(motor: MotorState) -> ca.SX:
    """A cable that becomes tight from an angle on."""
    return 20 * ca.fmax(motor.position - 0.2, 0) ** 2


def load(motor: MotorState) -> ca.SX:
    """A load that grows and falls again slowly."""
    return 1.5 * ca.exp(-(((motor.own[0] - 6) / 5) ** 2))


def tight_place(motor: MotorState) -> ca.SX:
    """Friction that is 1.5 Nm higher around one angle."""
    return -1.5 * ca.tanh(motor.speed / 0.01) * ca.exp(-(((motor.position + 0.2) / 0.25) ** 2))


LAWS: Mapping[str, Callable[[MotorState], ca.SX]] = {
    "hump": friction_hump,
    "cable": cable,
    "load": load,
    "tight_place": tight_place,
}


class Hidden(AbstractMotorTorque):
    """A torque that is not in the library."""

    name: ClassVar[str] = "hidden"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "level"
    smooth_states = 1

    law: str
    level: float = 1.0

    def rates(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        return ca.SX(1)

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        return values["level"] * LAWS[self.law](motor)


@cache
def robot() -> Robot:
    arm = robot_from_data({**yaml.safe_load(ARM), "sensors": {"encoder_noise": NOISE}}, "arm.yaml")
    return arm.with_values({f"motor_{number}.inertia": value for number, value in enumerate(INERTIA, 1)})


def measured(effects: tuple[str, ...], hidden: str = "", faster: float = 1.0) -> Record:
    """Simulate motion under a controller, as a log of a real machine: 20 s with a load, else 11 s."""
    N = LONG if hidden == "load" else SHORT
    placed = place_effects(robot(), [parse_effect(text, "test") for text in effects])
    beyond = (PlacedLaw("hidden@motor_2", Hidden(law=hidden), "motor_2"),) if hidden else ()
    rng, time = np.random.default_rng(1), T * np.arange(N)
    wanted = np.zeros((2, N, 2))
    for motor in range(2):
        for frequency, size in ((0.13, 0.5), (0.31, 0.3), (0.47, 0.15)):
            w, phase = 2 * np.pi * faster * frequency * rng.uniform(0.9, 1.1), rng.uniform(0, 6)
            wanted[0, :, motor] += size * np.sin(w * time + phase)
            wanted[1, :, motor] += size * w * np.cos(w * time + phase)
    plant = Plant(placed.robot, T, np.concatenate(wanted[:, 0]), substeps=4, laws=(*placed.laws, *beyond))
    position, torque = np.zeros((N, 2)), np.zeros((N, 2))
    for k in range(N):
        position[k], speed = np.split(plant.state, 2)
        held = robot().holding_torque(np.concatenate([position[k], np.zeros(2)]))
        torque[k] = held + [800, 200] * (wanted[0, k] - position[k]) + [40, 10] * (wanted[1, k] - speed)
        plant.advance(torque[k])
    noise = NOISE * rng.standard_normal(position.shape)
    return Record("log", T, position + noise, torque, np.ones(N, dtype=bool), imported=True)


def diagnosed(effects: tuple[str, ...], hidden: str = "", faster: float = 1.0) -> DiagnosisResult:
    return diagnosed_once(effects, hidden, faster)


@cache
def diagnosed_once(effects: tuple[str, ...], hidden: str, faster: float) -> DiagnosisResult:
    settings = ALL if hidden == "hump" else FEW
    return diagnose(measured(effects, hidden, faster), RobotWithEffects(robot(), ()), settings=settings)


def sizes(found: DiagnosisResult) -> dict[str, tuple[float, float]]:
    """Return value and standard deviation of the first parameter of every cause."""
    first = {f"{one.effect}@{one.location}": next(iter(one.parameters.values())) for one in found.diagnosis.causes}
    return {name: (parameter.value, parameter.std) for name, parameter in first.items()}


def curves_in(found: DiagnosisResult) -> list[str]:
    """Return the names of the curves without a law."""
    return [name for name in sizes(found) if effects()[name.partition("@")[0]].words]


@pytest.mark.parametrize(
    ("hidden", "curve", "faster"),
    [
        ("hump", "friction_curve", 1.0),
        ("cable", "torque_curve", 1.0),
        ("load", "torque_drift", FASTER),
        ("tight_place", "friction_over_position", 1.0),
    ],
)
def test_what_no_law_explains_is_named_by_class_and_joint(hidden: str, curve: str, faster: float) -> None:
    found = diagnosed((*FIRST, SECOND), hidden, faster)
    assert curves_in(found) == [f"{curve}@motor_2"]
    assert found.diagnosis.verdict == "partly_explained"
    assert (found.diagnosis.gap.closed_fraction or 0.0) > 0.95


@pytest.mark.parametrize(("hidden", "faster"), [("hump", 1.0), ("cable", 1.0), ("load", FASTER), ("tight_place", 1.0)])
def test_sizes_of_laws_are_not_moved_by_what_no_law_explains(hidden: str, faster: float) -> None:
    found = sizes(diagnosed((*FIRST, SECOND), hidden, faster))
    for text in (*FIRST, SECOND):
        name, _, value = text.partition(":")
        size, std = found[name]
        assert abs(size - float(value.partition("=")[2])) < max(3 * std, 0.01)
        assert std < 0.05 * size


def test_curve_is_in_budget_and_patch() -> None:
    found = diagnosed((*FIRST, SECOND), "hump")
    (share,) = [one for one in found.diagnosis.budget if one.effect == "friction_curve"]
    assert (share.joint, share.cause_class) == ("motor_2", "friction")
    assert share.share_last is not None
    assert share.share_last > 0
    assert "friction_curve" in [one.effect.name for one in found.patch]


def test_constant_torque_is_a_part_of_the_curve_at_its_motor() -> None:
    found = diagnosed((*FIRST, SECOND, "torque_bias@motor_2:level=1.5"), "cable")
    (curve,) = [one for one in found.diagnosis.causes if one.effect == "torque_curve"]
    assert "torque_bias@motor_2" not in sizes(found)
    first = curve.parameters["torque_1"]
    assert abs(first.value - 1.5) < 3 * first.std


def test_friction_of_known_laws_needs_no_curve() -> None:
    second = (SECOND, "viscous_friction@motor_2:coefficient=1.5")
    found = diagnosed((*FIRST, *second))
    assert sizes(found).keys() == {text.partition(":")[0] for text in (*FIRST, *second)}
    assert found.diagnosis.verdict == "explained"


def test_without_gap_there_is_no_curve() -> None:
    found = diagnosed(())
    assert found.diagnosis.verdict == "no_gap"
    assert not found.diagnosis.causes


def test_load_over_time_is_that_of_the_log_and_keeps_its_last_value() -> None:
    found = diagnosed((*FIRST, SECOND), "load", FASTER)
    (drift,) = [one.effect for one in found.patch if isinstance(one.effect, TorqueDrift)]
    assert drift.begin < 0.5
    assert drift.end == pytest.approx(2 / 3 * LONG * T, abs=0.02)
    constant = sum(one.effect.level for one in found.patch if isinstance(one.effect, TorqueBias))
    fitted = [constant + getattr(drift, f"torque_{number}") for number in range(1, 7)]
    time = np.linspace(drift.begin, drift.end, 6)
    true = 1.5 * np.exp(-(((time - 6) / 5) ** 2))
    np.testing.assert_allclose(fitted, true, atol=0.15)  # the true one is curved between the knots
    assert any(f"{drift.end:.3g} s" in text and drift.words in text for text in found.diagnosis.warnings)


def test_friction_that_drifts_by_a_law_needs_no_curve_over_time() -> None:
    drift = "friction_drift@motor_2:coulomb=2,time_constant=4"
    found = diagnosed((*FIRST, SECOND, drift), "", FASTER)
    assert "friction_drift@motor_2" in sizes(found)
    assert not curves_in(found)
