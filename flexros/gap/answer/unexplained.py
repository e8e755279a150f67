"""What the repaired model leaves of the gap, by joint, part of the motion and frequency band."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import rfft

from flexros.gap.held_out.errors_ahead import samples_ahead, signed_errors_ahead
from flexros.gap.schema import BandShare, Unexplained
from flexros.gap.where.bands import OctaveBands
from flexros.gap.where.motion import motion_of
from flexros.gap.where.regimes import regimes

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.answer.decision import Findings
    from flexros.gap.held_out.errors_ahead import AheadErrors

LEAST_SHARE = 0.005
"""Share of the gap from which the rest at a joint or in a regime is listed [1] (chosen)."""
SPACING = 0.005
"""Time between the prediction errors that are divided among bands [s]: up to 100 Hz, above most modes (chosen)."""
LOWEST = 1.0
"""Least upper end of the lowest band [Hz] (chosen)."""


def unexplained(findings: Findings, before: AheadErrors, after: AheadErrors) -> tuple[Unexplained, ...]:
    """Divide what is left of the gap of the held-out log among joints, within each joint among regimes and bands.

    The rest in further sensors counts at their joint; the bands are those of the motor.

    Args:
        findings: The fits of one log, checked on another.
        before: Errors of the nominal model.
        after: Errors of the repaired one.
    """
    robot, record = findings.model.robot, findings.held.record
    gap = before.mean - 1.0
    if gap <= 0:
        return ()
    motion = motion_of(record, robot)
    ends = after.starts + samples_ahead(record.sample_time)
    rest: FloatArray = (after.squares - 1.0) / after.squares.size / gap
    rows, spectra = [], None
    for motor, name in enumerate(robot.joint_names):
        parts = regimes(motion, motor, record.sample_time)
        own = rest[:, after.of_joint(motor, robot.n_motors)]
        shares = {regime: float(own[inside[ends]].sum()) for regime, inside in parts.items()}
        listed = {regime: parts[regime] for regime, share in shares.items() if share >= LEAST_SHARE}
        if not listed:
            continue
        spectra = spectra or _Spectra(findings)
        for regime, bands in spectra.shares(after.of_motor(motor), listed).items():
            divided = tuple(
                BandShare(band_hz=band, share=part * shares[regime]) for band, part in zip(spectra.bands, bands)
            )
            rows.append(Unexplained(joint=name, regime=regime, share=shares[regime], bands=divided))
    return tuple(sorted(rows, key=lambda row: -row.share))


class _Spectra:
    """Prediction errors of the repaired model in the held-out log, by band and time.

    Args:
        findings: The fits of one log, checked on another.
    """

    def __init__(self, findings: Findings) -> None:
        held = findings.held
        sample_time = held.record.sample_time
        step = max(1, round(SPACING / sample_time))
        repaired = findings.repaired
        (ahead,) = signed_errors_ahead(repaired.predictor, repaired.theta[:, None], held, step * sample_time)
        rows = (ahead.starts - ahead.starts[0]) // step
        self._ends = ahead.starts[0] + np.arange(rows[-1] + 1) * step + samples_ahead(sample_time)
        self._present = np.zeros(len(self._ends))
        self._present[rows] = 1.0
        self._errors = np.zeros((len(self._ends), ahead.errors.shape[1]))
        self._errors[rows] = ahead.limited
        self._octaves = OctaveBands.of(len(self._ends), step * sample_time, LOWEST)

    @property
    def bands(self) -> list[tuple[float, float]]:
        """Ends of the bands [Hz]."""
        hz = self._octaves.hz.tolist()
        return list(pairwise(hz))

    def shares(self, signals: list[int], parts: Mapping[str, BoolArray]) -> dict[str, FloatArray]:
        """Divide what is left of some signals among the bands, in each part of the motion.

        Noise, of which the floor is made, is taken as white.

        Args:
            signals: Numbers of the signals; without any, or where they leave no more than noise, all bands have the
                same share.
            parts: Samples of each part of the motion by its name, shape (n,).

        Returns:
            Shares that add up to 1 by the same names [1], shape (B,) each.
        """
        masks = np.array([inside[self._ends] * self._present for inside in parts.values()])
        power = self._octaves.power(rfft(self._errors[:, signals].sum(axis=1)))
        weights = self._octaves.weights(masks)
        widths = np.diff(self._octaves.hz) / self._octaves.hz[-1]
        left = np.array([of_band @ weight for of_band, weight in zip(power, weights)])
        left = np.maximum(left - widths[:, None] * masks.sum(axis=1), 0.0)
        left[:, left.sum(axis=0) == 0.0] = 1.0
        return dict(zip(parts, (left / left.sum(axis=0)).T))
