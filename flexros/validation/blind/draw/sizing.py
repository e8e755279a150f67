"""Search for the size of a deviation that has the drawn expected gain in log-likelihood."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.blind.plant.plant import BlindInputs, BlindPlant, UnstableCaseError
from flexros.validation.blind.plant.tool_view import seen_pose, tool_gain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.validation.blind.deviation import Deviation
    from flexros.validation.blind.draw.case_setting import Setting
    from flexros.validation.blind.draw.draw import Draft
    from flexros.validation.blind.draw.nominal_filter import NominalFilter
    from flexros.validation.blind.plant.plant import BlindRun

SETTLE = 1.0
"""Time at rest before a log [s] (chosen)."""
NEAR = 1.25
"""Factor by which the gain may differ from its target (chosen)."""
TRIALS = 12
"""Trials of a size (chosen)."""
LEVEL = 1e-3
"""Difference of the logarithms of two gains that counts as none [1] (chosen)."""
STEEPEST, FLATTEST = 6.0, 0.7
"""Bounds of the assumed exponent of the gain over the size; a small deviation has 2."""
TOOL_STEP = 4e-3
"""Time between two poses of the tool [s]."""


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """Noise-free runs of a case, to see how large a deviation is.

    Attributes:
        setting: How the case is run.
        reference: Reference with feedforward, shape (n, 3 M).
        filter: Filter of the robot without deviations.
        visibility: Share of the gain that coloured noise leaves [1].
    """

    setting: Setting
    reference: FloatArray
    filter: NominalFilter
    visibility: float = 1.0
    _plants: dict[tuple[str, ...], BlindPlant] = field(default_factory=dict)

    def run(self, deviations: Sequence[Deviation]) -> BlindRun:
        """Run without noise."""
        setting, n = self.setting, len(self.reference)
        still = np.zeros((n, setting.robot.n_motors))
        key = tuple(one.place for one in deviations)
        if key not in self._plants or any(one.effect == "extra_mode" for one in deviations):
            self._plants[key] = BlindPlant(setting.robot, deviations, setting.law, setting.sample_time)
        random = np.random.Generator(np.random.PCG64(0))
        lost, push = events(deviations, n, setting.sample_time, random)
        inputs = BlindInputs(self.reference, still, still, lost, push)
        return self._plants[key].run(inputs, SETTLE, deviations)

    def gain(self, deviation: Deviation) -> float:
        """Return the expected gain in log-likelihood [nats]; infinite where the loop runs away."""
        setting = self.setting
        try:
            run = self.run((deviation,))
        except UnstableCaseError:
            return np.inf
        if np.max(np.abs(run.encoder - self.reference[:, : setting.robot.n_motors])) > 2 * np.max(
            np.ptp(self.reference[:, : setting.robot.n_motors], axis=0)
        ):
            return np.inf
        if deviation.effect == "kinematic_error":
            states = run.states[:: round(TOOL_STEP / setting.sample_time)]
            poses = [seen_pose(setting.robot, one, states) for one in ((), (deviation,))]
            return tool_gain(poses[0], poses[1], setting.robot.tool_noise)
        seen = self.visibility * self.filter.expected_gain(run.encoder, run.command)
        return min(seen, self.filter.price(changed_numbers(deviation, setting.robot)))


def changed_numbers(deviation: Deviation, robot: Robot) -> dict[str, float]:
    """List the factors by which a deviation changes parameters of the robot; none where it is something else.

    Args:
        deviation: What is hidden.
        robot: The robot without it.
    """
    names = {
        "stiffness_error": [f"{deviation.location}.stiffness"],
        "damping_error": [f"{deviation.location}.damping"],
        "motor_inertia_error": [f"{deviation.location}.inertia"],
        "payload_error": [
            name
            for name, parameter in robot.parameters.items()
            if name.startswith((f"body_{len(robot.spec.bodies)}.mass", f"body_{len(robot.spec.bodies)}.inertia"))
            and parameter.value
        ],
    }.get(deviation.effect, [])
    return dict.fromkeys(names, 1 + deviation.parameters["relative"]) if names else {}


@dataclass(frozen=True, eq=False)
class Sized:
    """A deviation with its size.

    Attributes:
        deviation: What is hidden.
        gain: Its expected gain [nats].
        size: Its size over that of the draft [1].
    """

    deviation: Deviation
    gain: float
    size: float = 1.0


def find_size(draft: Draft, rehearsal: Rehearsal, target: float, near: float = NEAR, trials: int = TRIALS) -> Sized:
    """Find the size of a deviation for an expected gain.

    Args:
        draft: The deviation with its size open.
        rehearsal: Runs of the case.
        target: Expected gain [nats].
        near: Factor by which the gain may differ from it.
        trials: Most trials.

    Returns:
        The deviation whose gain is nearest; with less than requested where no physical size has as much.
    """
    size, largest = min(1.0, draft.largest), draft.largest
    tried: list[tuple[float, float]] = []
    best: Sized | None = None
    for _ in range(trials):
        deviation = draft.at(size)
        gain = rehearsal.gain(deviation)
        if not np.isfinite(gain):
            largest = size / 1.5
            size = min(largest, size / 4)
            continue
        if best is None or abs(np.log(max(gain, 1e-9) / target)) < abs(np.log(max(best.gain, 1e-9) / target)):
            best = Sized(deviation, gain, size)
        tried.append((float(np.log(size)), float(np.log(max(gain, 1e-9)))))
        if (
            1 / near < gain / target < near
            or _flat(tried, float(np.log(target)))
            or (size >= largest and gain < target)
        ):
            break
        size = min(largest, float(np.exp(_next(tried, float(np.log(target))))))
    if best is None:
        raise UnstableCaseError(f"{draft.effect} at {draft.location}: no size keeps the loop stable; draw anew")
    return best


def _next(tried: list[tuple[float, float]], target: float) -> float:
    """Go on with the power law through the last two trials, or within the trials on both sides of the target."""
    below = [one for one in tried if one[1] <= target]
    above = [one for one in tried if one[1] > target]
    if below and above:
        low, high = max(below), min(above)
        share = (target - low[1]) / max(high[1] - low[1], 1e-9)
        return low[0] + min(max(share, 0.15), 0.85) * (high[0] - low[0])
    slope = 2.0
    if len(tried) > 1 and abs(tried[-1][0] - tried[-2][0]) > 1e-6:
        slope = (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0])
    step = (target - tried[-1][1]) / float(np.clip(slope, FLATTEST, STEEPEST))
    return tried[-1][0] + float(np.clip(step, -4.0, 4.0))


def _flat(tried: Sequence[tuple[float, float]], target: float) -> bool:
    """Whether smaller sizes have the same gain, which is above the target."""
    return len(tried) > 1 and tried[-1][1] > target and abs(tried[-1][1] - tried[-2][1]) < LEVEL


def events(
    deviations: Sequence[Deviation], n: int, sample_time: float, random: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Draw when commands are lost and when the tool is pushed.

    Args:
        deviations: What is hidden.
        n: Number of samples.
        sample_time: Time between two samples [s].
        random: Random numbers.

    Returns:
        1 where a command is lost, and the shape of the pushes, each of shape (n,).
    """
    share = sum(one.parameters["share"] for one in deviations if one.effect == "lost_commands")
    lost = (random.uniform(size=n) < share).astype(float)
    push = np.zeros(n)
    time = np.arange(n) * sample_time
    for begin in np.cumsum(random.exponential(2.0, max(1, int(n * sample_time)))):
        width = float(random.uniform(0.05, 0.3))
        inside = (time >= begin) & (time < begin + width)
        push[inside] += float(random.uniform(-1.0, 1.0)) * np.sin(np.pi * (time[inside] - begin) / width) ** 2
    return lost, push
