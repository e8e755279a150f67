"""Conditions of the study: what differs between the plant and the model that the laws know."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.random_streams import Stream, generator

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

MODE_RATIO, MODE_DAMPING = 0.05, 0.02
"""Mass on the spring of the hidden mode over that of the last body, to which it is added without weight, and the
damping ratio (chosen)."""


@dataclass(frozen=True)
class Condition:
    """What the plant has and the model does not.

    Attributes:
        group: Kind of the condition.
        text: Its size in words.
        error: Relative error p of the model [1]: every stiffness is uniform within 1 +- p, every inertia within
            1 +- 2 p / 3, every damper and viscous friction within 1 +- min(2 p, 0.9), each independent.
        stiffness: Relative error of every spring [1], uniform within 1 +- it.
        payload: Relative error of mass and inertia of the last body [1], exact.
        coulomb: Coulomb friction of every motor over its largest torque of the motion [1].
        mode: Frequency of a hidden mode at the tool [Hz]; 0 for none.
        delay: Delay of the commands [s].
        noise: Factor on the noise of the encoders [1].
        sample_time: Time between two samples [s].
        undamped: Whether the gears have no dampers, though the model has: what the linearising laws assume.
    """

    group: str
    text: str
    error: float = 0.0
    stiffness: float = 0.0
    payload: float = 0.0
    coulomb: float = 0.0
    mode: float = 0.0
    delay: float = 0.0
    noise: float = 1.0
    sample_time: float = 5e-4
    undamped: bool = False

    @property
    def name(self) -> str:
        """Name in the record."""
        return f"{self.group}: {self.text}"

    @property
    def random(self) -> bool:
        """Whether the plants differ from draw to draw."""
        return bool(self.error or self.stiffness)


EXACT = Condition("exact model", "none")
MIXED = "everything together"
CONDITIONS: tuple[Condition, ...] = (
    EXACT,
    *(Condition("model error", f"{100 * p:g} %", error=p) for p in (0.05, 0.10, 0.15, 0.30)),
    *(Condition("stiffness error", f"{100 * p:g} %", stiffness=p) for p in (0.10, 0.30)),
    Condition("gears", "without dampers", undamped=True),
    *(Condition("payload", f"{100 * p:+g} %", payload=p) for p in (-0.2, 0.1, 0.2, 0.5)),
    *(Condition("Coulomb friction", f"{100 * p:g} % of the torque", coulomb=p) for p in (0.01, 0.03, 0.10)),
    *(Condition("hidden mode", f"{f:g} Hz", mode=f) for f in (40.0, 20.0, 12.0)),
    *(Condition("delay", f"{1e3 * t:g} ms", delay=t) for t in (5e-4, 1e-3, 2e-3, 4e-3)),
    *(Condition("encoder noise", f"times {k:g}", noise=k) for k in (5.0, 20.0, 100.0)),
    *(Condition("sample time", f"{1e3 * t:g} ms", sample_time=t) for t in (1e-3, 2e-3, 4e-3)),
    Condition(MIXED, "moderate", error=0.05, coulomb=0.01, delay=5e-4, noise=5.0),
    Condition(MIXED, "harsh", error=0.15, coulomb=0.03, delay=1e-3, noise=5.0, mode=40.0),
)
"""The grid: one cause at a time, then several together (chosen). 15 % and 30 % are the sets M1 and M2 of Paper C."""


def draw_values(robot: Robot, condition: Condition, draws: int, seed: int) -> dict[str, FloatArray]:
    """Draw the parameters of the plants.

    Args:
        robot: The nominal robot.
        condition: The condition.
        draws: Number of plants.
        seed: Seed; the same plants are drawn for every law and every size of the same kind of error.

    Returns:
        Value by parameter (SI), shape (draws,) each; empty where the plant has the numbers of the model.
    """
    if condition.undamped:
        return {name: np.zeros(draws) for name in robot.parameters if name.endswith(".damping")}
    if not (condition.random or condition.payload):
        return {}
    random = generator(seed, Stream.EXCITATION, 0)
    values: dict[str, FloatArray] = {}
    for names, share in _groups(robot, condition):
        factor = 1.0 + share * random.uniform(-1.0, 1.0, draws)
        values |= {name: robot.parameters[name].value * factor for name in names}
    if condition.payload:
        last = len(robot.spec.bodies)
        for name in (f"body_{last}.mass", f"body_{last}.inertia.yy"):
            nominal = values.get(name, np.full(draws, robot.parameters[name].value))
            values[name] = nominal * (1.0 + condition.payload)
    return values


def coulomb_values(largest: FloatArray, condition: Condition, draws: int) -> dict[str, FloatArray]:
    """Return the Coulomb levels of all motors, shape (draws,) each; empty without friction.

    Args:
        largest: Largest torque of each motor in the motion [Nm], shape (M,).
        condition: The condition.
        draws: Number of plants.
    """
    if not condition.coulomb:
        return {}
    return {
        f"coulomb_friction@motor_{motor + 1}.level": np.full(draws, condition.coulomb * torque)
        for motor, torque in enumerate(largest)
    }


def plant_effects(robot: Robot, condition: Condition) -> tuple[str, ...]:
    """Return the effects of the plant, as written in a scenario."""
    effects = []
    if condition.coulomb:
        effects += [f"coulomb_friction@{motor}:level=0" for motor in robot.joint_names]
    if condition.mode:
        effects.append(f"extra_mode@tool:frequency={condition.mode},ratio={MODE_RATIO},damping={MODE_DAMPING}")
    if condition.delay:
        effects.append(f"delay@all:time={condition.delay}")
    return tuple(effects)


def _groups(robot: Robot, condition: Condition) -> list[tuple[tuple[str, ...], float]]:
    """Return the parameters that share one random factor, each with its largest relative deviation."""
    p = condition.error
    groups: list[tuple[tuple[str, ...], float]] = []
    names = list(robot.parameters)
    for name in (name for name in names if name.endswith(".stiffness")):
        groups.append(((name,), condition.stiffness or p))
    if not p:
        return groups
    for number in range(1, len(robot.spec.bodies) + 1):
        groups.append(((f"body_{number}.mass", f"body_{number}.inertia.yy"), 2 * p / 3))
    for name in names:
        if name.startswith("motor_") and name.endswith(".inertia"):
            groups.append(((name,), 2 * p / 3))
        elif name.endswith((".damping", ".viscous_friction")) and robot.parameters[name].value > 0.0:
            groups.append(((name,), min(2 * p, 0.9)))
    return groups
