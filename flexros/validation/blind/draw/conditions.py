"""Conditions of a log: noise, clocks, tool tracker, and errors of the nominal model."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from flexros.errors import InputError
from flexros.identify.robot_file import IdentifiedValue

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

TOLERANCES = {
    "exact": (0.0, 0.0),
    "tolerance_1": (0.01, 0.1),
    "tolerance_3": (0.03, 0.3),
}
"""Relative standard deviation of stiffness and inertia, and of damping, by nuisance."""
FARTHEST = 2.5
"""Largest error of a number of the nominal model, in standard deviations (chosen)."""


@dataclass(frozen=True)
class Conditions:
    """Conditions of a recording.

    Attributes:
        colour: Coefficient of the first-order autoregression of the encoder noise; 0 for white noise.
        late: Standard deviation of the instants at which encoders are read, about their stamps [s].
        stamps: Standard deviation of the stamps about the even instants of reading [s].
        tool_late: How much later than its stamp a tool pose is [s].
        encoder_step: Step to which encoders round their positions, over the standard deviation of their noise [1]; 0:
            they do not round.
    """

    colour: float = 0.0
    late: float = 0.0
    stamps: float = 0.0
    tool_late: float = 0.0
    encoder_step: float = 0.0

    def figures(self) -> dict[str, float]:
        """Return the conditions by name, the step of encoders only where they round.

        A truth without rounding keeps the text, and so the seal, that it had before there was any.
        """
        values = asdict(self)
        if not self.encoder_step:
            del values["encoder_step"]
        return values

    @property
    def visibility(self) -> float:
        """Share of an expected gain that is left in coloured noise [1].

        Deviations show at low frequencies, where the noise has (1 + colour) / (1 - colour) times the density of white
        noise of the same variance.
        """
        return (1 - self.colour) / (1 + self.colour)


def draw_conditions(nuisance: str, random: np.random.Generator) -> Conditions:
    """Draw the conditions of a case: clean where the nominal model is exact.

    Args:
        nuisance: Key of `TOLERANCES`.
        random: Random numbers.
    """
    if nuisance == "exact":
        return Conditions()
    colour = float(random.uniform(0.4, 0.9)) if random.uniform() < 0.6 else 0.0
    kind = int(random.integers(3))
    return Conditions(
        colour=colour,
        late=float(random.uniform(0.3e-6, 2e-6)) if kind == 1 else 0.0,
        stamps=float(random.uniform(5e-6, 40e-6)) if kind == 2 else 0.0,
        tool_late=float(random.uniform(-2e-3, 2e-3)),
    )


def encoder_noise(rms: FloatArray, n: int, colour: float, random: np.random.Generator) -> FloatArray:
    """Make encoder noise, white or of first order.

    Args:
        rms: Standard deviation of each encoder [rad or m], shape (M,).
        n: Number of samples.
        colour: Coefficient of the autoregression.
        random: Random numbers.

    Returns:
        Noise, shape (n, M).
    """
    white = random.standard_normal((n, len(rms)))
    if colour:
        white = lfilter([np.sqrt(1 - colour**2)], [1.0, -colour], white, axis=0)
    return np.asarray(white * rms)


def tolerances(robot: Robot, nuisance: str) -> dict[str, float]:
    """List the parameters of a robot that are known within a tolerance.

    Args:
        robot: The robot.
        nuisance: Key of `TOLERANCES`.

    Returns:
        Relative standard deviation of stiffnesses, inertias, masses and dampings by name; none where exact.
    """
    firm, damping = TOLERANCES[nuisance]
    kinds = {"stiffness": firm, "mass": firm, "damping": damping}
    found = {}
    for name, parameter in robot.parameters.items():
        kind = name.rpartition(".")[2]
        sd = firm if ".inertia" in name else kinds.get(kind, 0.0)
        if sd and parameter.value:
            found[name] = sd
    return found


def believed_values(robot: Robot, nuisance: str, random: np.random.Generator) -> dict[str, IdentifiedValue]:
    """Draw the parameters of the nominal model: wrong by a factor within its declared tolerance.

    Args:
        robot: The true robot.
        nuisance: Key of `TOLERANCES`.
        random: Random numbers.

    Returns:
        Values and tolerances by name; none where the model is exact.
    """
    declared = tolerances(robot, nuisance)
    while True:
        error = np.clip(random.standard_normal(len(declared)), -FARTHEST, FARTHEST)
        values = {
            name: IdentifiedValue(robot.parameters[name].value * float(np.exp(sd * off)), sd)
            for (name, sd), off in zip(declared.items(), error, strict=True)
        }
        try:
            robot.with_values({name: one.value for name, one in values.items()})
        except InputError:  # an inertia tensor that no body has: draw again
            continue
        return values


@dataclass(frozen=True, eq=False)
class Tracker:
    """Tool tracker: its frame, and where its target sits on the tool.

    Attributes:
        rotation: From the base to its frame.
        origin: Origin of the base in its frame [m], shape (3,).
        target: Target in the frame of the tool [m], shape (3,).
        noise: Standard deviation of each component [m].
    """

    rotation: Rotation
    origin: FloatArray
    target: FloatArray
    noise: float

    @classmethod
    def draw(cls, robot: Robot, random: np.random.Generator) -> Tracker:
        """Draw the pose of a tracker next to a robot."""
        target = np.zeros(3) if robot.spec.tool.linear else random.uniform(-0.02, 0.02, 3)
        return cls(Rotation.random(random_state=random), random.uniform(-2.0, 2.0, 3), target, robot.tool_noise)

    def see(self, pose: FloatArray, random: np.random.Generator) -> FloatArray:
        """Measure tool poses [x y z qx qy qz qw], shape (n, 7), as positions [m], shape (n, 3)."""
        point = pose[:, :3] + Rotation.from_quat(pose[:, 3:]).apply(self.target)
        seen = self.rotation.apply(point) + self.origin
        return np.asarray(seen + self.noise * random.standard_normal(seen.shape))
