"""Sizes of the effects of a crowd: what each is worth when it is added last.

The noise-free run of the whole crowd is followed by filters of the robot with all its effects but one. Half the sum of
squared innovations over their variance is what that one is worth; what the sizes of the others could take over, and
the numbers of a tolerated nominal model at their prior, does not count.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.blind.draw.nominal_filter import SKIPPED, filter_gain
from flexros.validation.blind.draw.sizing import SETTLE, Sized, changed_numbers, events, find_size
from flexros.validation.blind.plant.plant import BlindInputs, BlindPlant, UnstableCaseError
from flexros.validation.blind.plant.replay import Replay

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.validation.blind.deviation import Deviation
    from flexros.validation.blind.draw.draw import Draft
    from flexros.validation.blind.draw.sizing import Rehearsal
    from flexros.validation.blind.plant.plant import BlindRun

LEAST = 50.0
"""Least gain of every effect of a crowd when added last [nats] (contract of section 10)."""
ROUNDS = 4
"""Rounds in which effects that are worth less are made larger (chosen)."""
FEWEST = 3
"""Least number of effects that a crowd is left with (the requirement)."""
ALONE_TRIALS, ALONE_NEAR = 4, 3.0
"""Trials of the size of an effect alone, and the factor by which its gain may differ from the target (chosen)."""
SMALLEST_STEP, LARGEST_STEP = 1.5, 6.0
"""Factors by which a size is raised in a round (chosen)."""
ROUNDING = "encoder_quantization"


@dataclass(frozen=True, eq=False)
class CrowdRehearsal:
    """Noise-free runs of a crowd, followed without one of its effects at a time.

    Attributes:
        alone: Rehearsal of single effects in the same setting.
    """

    alone: Rehearsal
    _filters: dict[tuple[str, ...], BlindPlant] = field(default_factory=dict)

    def gains(self, crowd: Sequence[Deviation]) -> tuple[float, ...]:
        """Compute what each effect is worth when it is added last [nats].

        Rounding of encoders is noise for the others, and worth what it is alone.

        Args:
            crowd: All that is hidden.

        Raises:
            UnstableCaseError: The loop ran away.
        """
        smooth = [one for one in crowd if one.effect != ROUNDING]
        run, noise = self.alone.run(smooth), self._noise(crowd)
        missing = [self._innovations(run, [*smooth[:k], *smooth[k + 1 :]], noise) for k in range(len(smooth))]
        slopes = self.alone.filter.tolerance_slopes(run.encoder, run.command)
        worth = dict(zip((one.place for one in smooth), _last(missing, slopes), strict=True))
        return tuple(
            self.alone.gain(one) if one.effect == ROUNDING else self._visible(one, worth[one.place]) for one in crowd
        )

    def _visible(self, one: Deviation, gain: float) -> float:
        """Return what noise and tolerance leave of a gain."""
        price = self.alone.filter.price(changed_numbers(one, self.alone.setting.robot))
        return min(self.alone.visibility * gain, price)

    def _noise(self, crowd: Sequence[Deviation]) -> FloatArray:
        """Return the standard deviation of each encoder with its rounding [rad or m], shape (M,)."""
        robot = self.alone.setting.robot
        variance = robot.encoder_noise**2
        for one in crowd:
            if one.effect == ROUNDING:
                variance[robot.joint_names.index(one.location)] += one.parameters["step"] ** 2 / 12
        return np.asarray(np.sqrt(variance))

    def _innovations(self, run: BlindRun, others: Sequence[Deviation], noise: FloatArray) -> FloatArray:
        """Follow a run with a plant that has the other effects; innovations over their noise, shape (n,)."""
        setting, n = self.alone.setting, len(run.encoder)
        step = setting.sample_time

        def gain(robot: Robot) -> FloatArray:
            return filter_gain(robot, step, noise)[0]

        key = tuple(one.place for one in others)
        if key not in self._filters or any(one.effect == "extra_mode" for one in others):
            self._filters[key] = BlindPlant(setting.robot, others, Replay(), step, correction=gain)
        plant, still = self._filters[key], np.zeros_like(run.encoder)
        lost, push = events(others, n, step, np.random.Generator(np.random.PCG64(0)))
        recorded = np.hstack([run.encoder, still, run.command])
        followed = plant.run(BlindInputs(recorded, still, still, lost, push), SETTLE, others)
        skip = min(round(SKIPPED / step), n // 2)
        whitener = filter_gain(plant.robot, step, noise)[1]
        return np.asarray(((run.encoder - followed.encoder)[skip:] @ whitener.T).ravel())


def _last(missing: Sequence[FloatArray], slopes: FloatArray | None) -> list[float]:
    """Compute gains less what the others take over by their sizes, and tolerated numbers at their prior.

    Args:
        missing: Innovations without each effect, each of shape (n,).
        slopes: Derivatives by tolerated numbers, in their standard deviations, shape (n, P); None for none.
    """
    E = np.stack(missing, axis=1)
    size = np.linalg.norm(E, axis=0)
    E = E / np.where(size > 0, size, 1.0)
    free = np.empty((len(E), 0)) if slopes is None else slopes
    gains = []
    for k in range(E.shape[1]):
        X = np.hstack([np.delete(E, k, axis=1), free])
        prior = np.concatenate([np.full(E.shape[1] - 1, 1e-12), np.ones(free.shape[1])])
        score = X.T @ E[:, k]
        unit = 1 - score @ np.linalg.solve(X.T @ X + np.diag(prior), score)
        gains.append(float(max(unit, 0.0) * size[k] ** 2 / 2))
    return gains


def size_crowd(drafts: Sequence[Draft], targets: Sequence[float], rehearsal: Rehearsal) -> tuple[Sized, ...]:
    """Find sizes with which every effect of a crowd is well above the noise.

    Args:
        drafts: The effects with their sizes open.
        targets: Gain that each is drawn for [nats].
        rehearsal: Runs of the case.

    Returns:
        The effects that are worth `LEAST` or more when added last; fewer than drafted where some cannot be.

    Raises:
        UnstableCaseError: The loop ran away, or too few are left; draw anew.
    """
    runs = CrowdRehearsal(rehearsal)
    crowd = [find_size(one, rehearsal, to, ALONE_NEAR, ALONE_TRIALS) for one, to in zip(drafts, targets, strict=True)]
    for last in (*[False] * ROUNDS, True):
        gains = runs.gains([one.deviation for one in crowd])
        crowd = [replace(one, gain=gain) for one, gain in zip(crowd, gains, strict=True)]
        raised = [_raised(*one) for one in zip(drafts, crowd, targets, strict=True)]
        if last or [one.size for one in raised] == [one.size for one in crowd]:
            break
        crowd = raised
    kept = [one for one in crowd if one.gain >= LEAST]
    if FEWEST <= len(kept) < len(crowd):
        gains = runs.gains([one.deviation for one in kept])
        kept = [replace(one, gain=gain) for one, gain in zip(kept, gains, strict=True)]
    if len(kept) < FEWEST or min(one.gain for one in kept) < LEAST:
        raise UnstableCaseError("too few effects of a crowd are well above the noise; draw anew")
    return tuple(kept)


def _raised(drafted: Draft, one: Sized, target: float) -> Sized:
    """Make an effect larger that is worth too little."""
    if one.gain >= LEAST:
        return one
    factor = float(np.clip(np.sqrt(target / max(one.gain, 1e-9)), SMALLEST_STEP, LARGEST_STEP))
    size = min(drafted.largest, one.size * factor)
    return Sized(drafted.at(size), one.gain, size)
