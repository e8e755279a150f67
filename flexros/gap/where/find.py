"""Locate a gap: the excess of prediction errors over noise by signal, joint, band and regime, with p-values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.noise.autoregression import white_spectrum
from flexros.gap.settings import WhereSettings
from flexros.gap.where.base import AbstractSimulatedView, AbstractTestedView, ViewExcess, views
from flexros.gap.where.prediction_errors import PredictionErrors
from flexros.gap.where.reported_excess import mapped, reported, significant
from flexros.gap.where.significance import p_values
from flexros.gap.where.views.position_bands import PositionBands
from flexros.random_streams import generator

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.schema import Excess
    from flexros.gap.where.base import Statistics
    from flexros.gap.where.channel import Channel, ErrorSample
    from flexros.gap.where.prediction_errors import SensorErrors
    from flexros.record.record import Record
    from flexros.robot import Robot

NULL_STREAM = 40
"""Stream of random numbers of the simulated logs without a gap."""
LEAST_SAMPLES = 100
"""Samples below which no gap is located (chosen)."""
FEWEST = 20
"""Simulated logs that are enough for a p-value of 0.05, where there is no time for more."""


@dataclass(frozen=True, eq=False)
class Where:
    """Locations of a gap.

    Attributes:
        locations: Significant locations, the most concentrated ones first; empty where nothing exceeds the noise.
        mapped: Locations for maps, significant or not: per joint and octave band over the regime "all", per joint and
            regime over the whole band, and the most significant order of each joint.
        p_value: Smallest p-value of all locations that are tested by simulated logs [1].
        excess: Mean square of the prediction errors of the positions over that of noise, less one, by motor [1], (M,).
    """

    locations: tuple[Excess, ...]
    mapped: tuple[Excess, ...]
    p_value: float
    excess: FloatArray


def where(
    prediction: PredictedLog,
    record: Record,
    robot: Robot,
    seed: int,
    *,
    tool_error: FloatArray | None = None,
    sensors: Sequence[SensorErrors] = (),
    spectrum: FloatArray | None = None,
    settings: WhereSettings | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Where:
    """Locate a gap without any hypothesis on its cause.

    Excess is the power in a location less that of noise. Each file in `flexros.gap.where.views` divides the prediction
    errors in its own way.

    Args:
        prediction: Predictions of the nominal model; speeds and gear torques come from its states where these are kept.
        record: The log, n samples of M motors, with its periodic parts.
        robot: The nominal robot.
        seed: Seed of the simulated logs without a gap.
        tool_error: Measured minus predicted tool positions [m], shape (n_t, 3), with frame and offset of the tracker
            removed; None where there are none.
        sensors: Prediction errors of further sensors.
        spectrum: Spectrum of the prediction errors without a gap, see `flexros.gap.noise.autoregression`, shape
            (any, M); default: white, which holds for predictors with a small gain.
        settings: Settings of the search.
        stop: Asked before each simulated log; True leaves the others out once there are `FEWEST`.
    """
    settings = WhereSettings() if settings is None else settings
    record = replace(record, valid=record.valid & np.isfinite(prediction.innovations).all(axis=1))
    n_valid = int(record.valid.sum())
    if n_valid < LEAST_SAMPLES:
        return Where((), (), 1.0, np.zeros(robot.n_motors))
    spectrum = white_spectrum(robot.n_motors) if spectrum is None else spectrum
    errors = PredictionErrors(prediction, record, robot, spectrum, tool_error, settings, tuple(sensors))
    looks = [look for view in views() if issubclass(view, AbstractSimulatedView) for look in view.of_log(errors)]
    excesses = _excesses(looks, seed, settings.realisations, stop)
    simulated = [location for look, excess in zip(looks, excesses) for location in look.locations(excess)]
    tested = [location for view in views() if issubclass(view, AbstractTestedView) for location in view.of_log(errors)]
    excess = np.zeros(robot.n_motors)
    excess[record.predicted] = [found.total for look, found in zip(looks, excesses) if isinstance(look, PositionBands)]
    return Where(
        locations=(*reported(simulated, settings), *significant(tested, settings)),
        mapped=mapped(simulated),
        p_value=min((location.p_value for location in simulated), default=1.0),
        excess=excess / n_valid,
    )


def _excesses(
    looks: Sequence[AbstractSimulatedView], seed: int, most: int, stop: Callable[[], bool]
) -> list[ViewExcess]:
    """Compare the measured errors with simulated logs without a gap: as many as asked for, or as there is time for."""
    channels = list(dict.fromkeys(look.channel for look in looks))
    measured = _statistics(looks, {channel: channel.measured() for channel in channels})
    power = [np.zeros_like(statistics.power) for statistics in measured]
    total = np.zeros(len(looks))
    null = []
    for log in range(most):
        if log >= FEWEST and stop():
            break
        samples = {
            channel: channel.simulated(generator(seed, NULL_STREAM, log, place))
            for place, channel in enumerate(channels)
        }
        drawn = _statistics(looks, samples)
        for mean, statistics in zip(power, drawn):
            mean += statistics.power
        total += np.array([statistics.total for statistics in drawn])
        null.append(np.concatenate([statistics.score for statistics in drawn]))
    power, total = [mean / len(null) for mean in power], total / len(null)
    sized = [look.sized for look in looks]
    tested = np.concatenate(sized)
    p_value = np.ones(len(tested))
    p_value[tested] = p_values(
        np.concatenate([statistics.score for statistics in measured])[tested], np.array(null)[:, tested]
    )
    ends = np.cumsum([len(each) for each in sized])[:-1]
    totals = [statistics.total - float(mean) for statistics, mean in zip(measured, total)]
    groups = [[other for view, other in zip(looks, totals) if type(view) is type(look)] for look in looks]
    return [
        ViewExcess(
            excess=statistics.power - mean,
            p_value=p,
            sized=enough,
            total=own,
            whole=max(float(sum(max(other, 0.0) for other in group)), 1e-300),
            n_channels=len(group),
        )
        for statistics, mean, p, enough, own, group in zip(
            measured, power, np.split(p_value, ends), sized, totals, groups
        )
    ]


def _statistics(looks: Sequence[AbstractSimulatedView], samples: Mapping[Channel, ErrorSample]) -> list[Statistics]:
    return [look.statistics(samples[look.channel]) for look in looks]
