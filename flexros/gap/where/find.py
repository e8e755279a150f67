"""Where a gap shows: the excess of prediction errors over noise by signal, joint, band and regime, with p-values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.where.channels import motor_channels, tool_channels
from flexros.gap.where.floor import white
from flexros.gap.where.periodic import periodic_places
from flexros.gap.where.places import Seen, places_of
from flexros.gap.where.score import p_values
from flexros.gap.where.selection import LEAST_SHARE, looked_at, told
from flexros.gap.where.settings import WhereSettings
from flexros.random_streams import generator

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.schema import Excess
    from flexros.gap.where.channel import Channel
    from flexros.record.record import Record
    from flexros.robot import Robot

NULL_STREAM = 40
"""Stream of random numbers of the simulated logs without gap."""
LEAST_SAMPLES = 100
"""Samples below which no places are looked for (chosen)."""


@dataclass(frozen=True, eq=False)
class Where:
    """Where a gap shows.

    Attributes:
        places: Significant places, the most telling ones first; empty where nothing exceeds the noise.
        looked: Significant or not: per joint and octave band over the regime "all", per joint and regime over the whole
            band, and per joint the order that stands out most.
        p_value: Smallest p-value of all places [1].
        excess: Mean square of the prediction errors of the positions over that of noise, less one, by motor [1], (M,).
    """

    places: tuple[Excess, ...]
    looked: tuple[Excess, ...]
    p_value: float
    excess: FloatArray


def where(
    prediction: PredictedLog,
    record: Record,
    robot: Robot,
    seed: int,
    *,
    tool_error: FloatArray | None = None,
    projected: FloatArray | None = None,
    spectrum: FloatArray | None = None,
    settings: WhereSettings | None = None,
) -> Where:
    """Find where a gap shows, before any hypothesis.

    Excess is power over what noise alone would put into a place. Two signals of each motor are looked at: its
    prediction errors, and their sudden part, which tells when the cause sets in (`flexros.gap.where.sudden`).

    Args:
        prediction: Of the nominal model; its states, where kept, tell the speeds and gear torques.
        record: The log, n samples of M motors; the lines of its periodic parts tell linear from nonlinear, with
            p-values of their own.
        robot: The nominal robot.
        seed: Seed of the simulated logs without gap.
        tool_error: Measured minus predicted tool positions [m], shape (n_t, 3), with frame and offset of the tracker
            taken off; None where there are none.
        projected: Prediction errors from which all that the tolerance of the model can explain was taken off [rad or
            m], shape (n, M); they are looked at instead of those of the prediction.
        spectrum: Spectrum of the prediction errors without gap, from `flexros.gap.where.floor`, shape (any, M);
            default: white, which is right of predictors with a small gain. That of a linearised predictor does not
            hold where springs are nonlinear.
        settings: Numbers of the search.

    Returns:
        The places.
    """
    chosen = WhereSettings() if settings is None else settings
    errors = prediction.innovations if projected is None else projected
    record = replace(record, valid=record.valid & np.isfinite(errors).all(axis=1))
    if record.valid.sum() < LEAST_SAMPLES:
        return Where((), (), 1.0, np.zeros(robot.n_motors))
    scaled = errors / np.maximum(prediction.sd, 1e-300)
    noise = white(robot.n_motors) if spectrum is None else spectrum
    motors = motor_channels(prediction, record, robot, noise, chosen)
    signals = [(channel, channel.shown(scaled[:, number])) for number, channel in enumerate(motors)]
    if tool_error is not None and record.tool is not None and len(tool_error):
        signals += tool_channels(tool_error, record, motors, chosen)
    seen = _seen(signals, seed, chosen)
    found = places_of(seen)
    tested = np.array([place.p_value for place in found])
    whole = [one.excess[one.full, 0] for one in seen[: robot.n_motors]]
    lines = periodic_places(errors, record.valid, record.parts, record.sample_time, robot.joint_names)
    at_lines = [place for place in lines if place.p_value <= chosen.significant and place.share >= LEAST_SHARE]
    return Where(
        places=(*told(found, chosen), *at_lines),
        looked=looked_at(found),
        p_value=float(tested.min(initial=1.0)),
        excess=np.array(whole) / max(int(record.valid.sum()), 1),
    )


def _seen(signals: list[tuple[Channel, FloatArray]], seed: int, settings: WhereSettings) -> list[Seen]:
    """Look at all signals and at as many simulated ones without gap, and bring the p-values back to the signals."""
    looks = [channel.look(values) for channel, values in signals]
    null = []
    expected = [np.zeros_like(look.bands) for look in looks]
    sudden = [np.zeros_like(look.sudden) for look in looks]
    orders = [np.zeros_like(look.orders) for look in looks]
    for number in range(settings.realisations):
        row = []
        for place, (channel, _) in enumerate(signals):
            drawn = channel.noise(generator(seed, NULL_STREAM, number, place))
            expected[place] += drawn.bands / settings.realisations
            sudden[place] += drawn.sudden / settings.realisations
            orders[place] += drawn.orders / settings.realisations
            row.append(drawn.statistics())
        null.append(np.concatenate(row))
    sized = np.concatenate([channel.sized for channel, _ in signals])
    p_value = np.ones(len(sized))
    statistics = np.concatenate([look.statistics() for look in looks])
    p_value[sized] = p_values(statistics[sized], np.array(null)[:, sized])
    ends = np.cumsum([len(look.statistics()) for look in looks])[:-1]
    return [
        Seen.of(channel, look, look.bands - mean, look.sudden - fresh, look.orders - turning, p, size)
        for (channel, _), look, mean, fresh, turning, p, size in zip(
            signals, looks, expected, sudden, orders, np.split(p_value, ends), np.split(sized, ends)
        )
    ]
