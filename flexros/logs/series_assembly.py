"""From decoded messages to time series: one order of joints, stamps sorted and without repeats, oddities named."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.logs.messages.joint_state import FIELDS, JointStateLayout
from flexros.logs.time_series import JointSeries, PoseSeries

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.logs.messages.bulk_decode import Segment, TopicDecoder, TopicLayout
    from flexros.logs.messages.pose_stamped import PoseStampedLayout

    L = TypeVar("L", bound=TopicLayout)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Messages of a topic as rows: stamps increasing, log times where they differ, one block of columns per span."""

    stamp: IntArray
    received: IntArray | None
    columns: tuple[FloatArray, ...]


def _majority(
    topic: str, segments: Sequence[Segment[L]], key: Callable[[L], Hashable], what: str, warnings: list[str]
) -> list[Segment[L]]:
    """Keep the messages that agree with most others in `key`."""
    counts: Counter[Hashable] = Counter()
    for segment in segments:
        counts[key(segment.layout)] += len(segment.stamp)
    chosen, _ = counts.most_common(1)[0]
    if n_others := counts.total() - counts[chosen]:
        warnings.append(f"{topic}: {n_others} of {counts.total()} messages have other {what} than the rest, left out")
    return [segment for segment in segments if key(segment.layout) == chosen]


def _rows(
    topic: str, segments: Sequence[Segment[L]], columns: Sequence[Sequence[FloatArray]], warnings: list[str]
) -> _Rows:
    """Sort by stamp and drop repeats.

    Args:
        topic: Name for warnings.
        segments: Messages.
        columns: For every segment its columns.
        warnings: Receives what was noticed.
    """
    stamp = np.concatenate([segment.stamp for segment in segments])
    log_time = np.concatenate([segment.log_time for segment in segments])
    merged = [np.concatenate(parts) for parts in zip(*columns, strict=True)]
    if not stamp.any():
        warnings.append(f"{topic}: no message has a header.stamp, the log time is used instead")
        stamp = log_time
    arrival = np.argsort(np.concatenate([segment.order for segment in segments]))
    if np.any(np.diff(stamp[arrival]) < 0):
        warnings.append(f"{topic}: messages are not in the order of their stamps, they were sorted")
    order = arrival[np.argsort(stamp[arrival], kind="stable")]
    stamp, log_time, merged = stamp[order], log_time[order], [values[order] for values in merged]
    repeated = np.flatnonzero(np.diff(stamp) == 0) + 1
    if len(repeated):
        keep = np.ones(len(stamp), bool)
        keep[repeated] = False
        first = np.flatnonzero(keep)[np.cumsum(keep)[repeated] - 1]
        equal = np.all([np.all(_same(v[repeated], v[first]), axis=1) for v in merged], axis=0)
        if n_equal := int(np.count_nonzero(equal)):
            warnings.append(f"{topic}: {n_equal} repeated messages (same stamp, same values) were dropped")
        if n_unequal := len(repeated) - n_equal:
            warnings.append(
                f"{topic}: {n_unequal} messages repeat a stamp with other values, the first of each was kept"
            )
        stamp, log_time, merged = stamp[keep], log_time[keep], [values[keep] for values in merged]
    return _Rows(stamp, None if np.array_equal(stamp, log_time) else log_time, tuple(merged))


def _same(a: FloatArray, b: FloatArray) -> BoolArray:
    same: BoolArray = (a == b) | (np.isnan(a) & np.isnan(b))
    return same


def _report(topic: str, name: str, values: FloatArray | None, warnings: list[str]) -> None:
    if values is not None and (n_bad := int(np.count_nonzero(~np.isfinite(values).all(axis=1)))):
        warnings.append(f"{topic}: {name} is not a finite number in {n_bad} of {len(values)} messages")


def _damaged(topic: str, decoder: TopicDecoder[L], warnings: list[str]) -> None:
    if decoder.damaged.number:
        warnings.append(
            f"{topic}: {decoder.damaged.number} of {decoder.n_messages} messages are damaged and were left out "
            f"(the first: {decoder.damaged.first})"
        )


def joint_series(topic: str, decoder: TopicDecoder[JointStateLayout], warnings: list[str]) -> JointSeries | None:
    """Make a time series of JointState messages.

    Args:
        topic: Name of the topic, for warnings.
        decoder: Its decoded messages.
        warnings: Receives what was noticed.

    Returns:
        The series with the joints in the order of the first message, or None if no message could be decoded.
    """
    _damaged(topic, decoder, warnings)
    if not decoder.segments:
        return None
    segments = _majority(topic, decoder.segments, lambda layout: frozenset(layout.names), "joint names", warnings)
    names = min(segments, key=lambda segment: int(segment.order[0])).layout.names
    columns = [_in_order(segment, names) for segment in segments]
    rows = _rows(topic, segments, columns, warnings)
    filled = np.array([[span.size > 0 for span in segment.layout.message.spans] for segment in segments])
    values: dict[str, FloatArray | None] = {}
    for i, field in enumerate(FIELDS):
        values[field] = rows.columns[i] if filled[:, i].any() else None
        _report(topic, field, values[field], warnings)
    return JointSeries(rows.stamp, names, values["position"], values["velocity"], values["effort"], rows.received)


def _in_order(segment: Segment[JointStateLayout], names: Sequence[str]) -> list[FloatArray]:
    """Columns in the order of `names`; NaN where the messages leave a field empty."""
    place = [segment.layout.names.index(name) for name in names]
    empty = np.full((len(segment.stamp), len(names)), np.nan)
    if place == list(range(len(names))):
        return [values if values.shape[1] else empty for values in segment.numbers]
    return [values[:, place] if values.shape[1] else empty for values in segment.numbers]


def pose_series(topic: str, decoder: TopicDecoder[PoseStampedLayout], warnings: list[str]) -> PoseSeries | None:
    """Make a time series of PoseStamped messages.

    Args:
        topic: Name of the topic, for warnings.
        decoder: Its decoded messages.
        warnings: Receives what was noticed.

    Returns:
        The series, or None if no message could be decoded.
    """
    _damaged(topic, decoder, warnings)
    if not decoder.segments:
        return None
    segments = _majority(topic, decoder.segments, lambda layout: layout.frame_id, "frames", warnings)
    rows = _rows(topic, segments, [segment.numbers for segment in segments], warnings)
    pose = rows.columns[0]
    _report(topic, "pose", pose, warnings)
    return PoseSeries(rows.stamp, segments[0].layout.frame_id, pose[:, :3].copy(), pose[:, 3:].copy(), rows.received)
