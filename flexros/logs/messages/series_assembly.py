"""From decoded messages to time series: keep the majority layout, sort by stamp, drop repeats, report oddities."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.logs.messages.bulk_decode import Segment, TopicDecoder, TopicLayout
    from flexros.logs.messages.codec import AbstractSeriesCodec
    from flexros.logs.time_series import Series

    L = TypeVar("L", bound=TopicLayout)


@dataclass(frozen=True, eq=False)
class SortedRows:
    """Messages of a topic as rows in the order of their stamps.

    Attributes:
        stamp: Stamps [ns], increasing, shape (n,).
        received: Log times [ns], shape (n,); None if they equal the stamps.
        columns: One array per span, shape (n, size).
    """

    stamp: IntArray
    received: IntArray | None
    columns: tuple[FloatArray, ...]


def assemble_series(
    codec: AbstractSeriesCodec[L], topic: str, decoder: TopicDecoder[L], warnings: list[str]
) -> Series | None:
    """Make the time series of a topic.

    Args:
        codec: Codec of its message type.
        topic: Name of the topic, for warnings.
        decoder: Its decoded messages.
        warnings: Receives what was left out or repaired.

    Returns:
        The series, or None if no message could be decoded.
    """
    if decoder.damaged.number:
        warnings.append(
            f"{topic}: {decoder.damaged.number} of {decoder.n_messages} messages are damaged and were left out "
            f"(the first: {decoder.damaged.first})"
        )
    return codec.assemble(topic, decoder.segments, warnings) if decoder.segments else None


def majority(
    topic: str, segments: Sequence[Segment[L]], key: Callable[[L], Hashable], quantity: str, warnings: list[str]
) -> list[Segment[L]]:
    """Keep the messages whose layouts share the most frequent key; `quantity` names the key in the warning."""
    counts: Counter[Hashable] = Counter()
    for segment in segments:
        counts[key(segment.layout)] += len(segment.stamp)
    chosen, _ = counts.most_common(1)[0]
    if n_others := counts.total() - counts[chosen]:
        warnings.append(
            f"{topic}: {n_others} of {counts.total()} messages have other {quantity} than the rest, left out"
        )
    return [segment for segment in segments if key(segment.layout) == chosen]


def sorted_rows(
    topic: str, segments: Sequence[Segment[L]], columns: Sequence[Sequence[FloatArray]], warnings: list[str]
) -> SortedRows:
    """Sort messages by stamp and drop repeats.

    Args:
        topic: Name of the topic, for warnings.
        segments: Messages.
        columns: Columns of every segment, in the same order of quantities.
        warnings: Receives what was left out or repaired.
    """
    stamp = np.concatenate([segment.stamp for segment in segments])
    same = all(segment.log_time is segment.stamp for segment in segments)
    log_time = stamp if same else np.concatenate([segment.log_time for segment in segments])
    merged = [np.concatenate(parts) for parts in zip(*columns, strict=True)]
    if not stamp.any():
        warnings.append(f"{topic}: no message has a header.stamp, the log time is used instead")
        stamp = log_time
    order = np.concatenate([segment.order for segment in segments])
    # Nearly always they are in order, and a copy of a long log takes as much memory again.
    if np.any(order[1:] < order[:-1]) or np.any(stamp[1:] < stamp[:-1]):
        # back to the order of arrival first: the stable sort by stamp then keeps the first of several equal stamps
        arrival = np.argsort(order)
        if np.any(np.diff(stamp[arrival]) < 0):
            warnings.append(f"{topic}: messages are not in the order of their stamps, they were sorted")
        order = arrival[np.argsort(stamp[arrival], kind="stable")]
        stamp, log_time, merged = stamp[order], log_time[order], [values[order] for values in merged]
    repeated = np.flatnonzero(np.diff(stamp) == 0) + 1
    if len(repeated):
        keep = np.ones(len(stamp), bool)
        keep[repeated] = False
        kept_row = np.flatnonzero(keep)[np.cumsum(keep)[repeated] - 1]
        equal = np.all([np.all(_same(v[repeated], v[kept_row]), axis=1) for v in merged], axis=0)
        if n_equal := int(np.count_nonzero(equal)):
            warnings.append(f"{topic}: {n_equal} repeated messages (same stamp, same values) were dropped")
        if n_unequal := len(repeated) - n_equal:
            warnings.append(
                f"{topic}: {n_unequal} messages repeat a stamp with other values, the first of each was kept"
            )
        stamp, log_time, merged = stamp[keep], log_time[keep], [values[keep] for values in merged]
    return SortedRows(stamp, None if np.array_equal(stamp, log_time) else log_time, tuple(merged))


def _same(a: FloatArray, b: FloatArray) -> BoolArray:
    same: BoolArray = (a == b) | (np.isnan(a) & np.isnan(b))
    return same


def warn_of_not_finite(topic: str, field: str, columns: Sequence[FloatArray], warnings: list[str]) -> None:
    """Count the messages with NaN or infinity in a field of one or several columns.

    Entries that are never finite are unknown, such as the torque of a gripper, unless that is the whole field.
    """
    finite = np.concatenate([np.isfinite(values) for values in columns], axis=1)
    known = finite.any(axis=0)
    usable = finite[:, known | ~known.any()]
    if n_bad := int(np.count_nonzero(~np.all(usable, axis=1))):
        warnings.append(f"{topic}: {field} is not a finite number in {n_bad} of {len(usable)} messages")
