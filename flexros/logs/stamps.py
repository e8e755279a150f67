"""Stamps of samples and messages: maps sample k to simulated time and back."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.logs.cdr_cursor import MessageError

if TYPE_CHECKING:
    from flexros.arrays import IntArray

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""

_LITTLE_ENDIAN = struct.Struct("<4xiI").unpack_from
_BIG_ENDIAN = struct.Struct(">4xiI").unpack_from

START_NS = NANOSECONDS
"""Stamp of sample 0 [ns]: simulated time starts at 1 s, because 0 means "not set" in ROS."""


def stamp_ns(k: int, sample_time: float) -> int:
    """Return the stamp of sample k: 1 s + round(k T).

    Args:
        k: Sample number, from 0.
        sample_time: T [s].

    Returns:
        Simulated time [ns].
    """
    return START_NS + round(k * sample_time * 1e9)


def stamps_ns(n: int, sample_time: float) -> IntArray:
    """Return the stamps of the samples 0 to n - 1, equal to `stamp_ns` for each.

    Args:
        n: Number of samples.
        sample_time: T [s].

    Returns:
        Simulated time [ns], shape (n,).
    """
    stamps: IntArray = START_NS + np.rint(np.arange(n) * sample_time * 1e9).astype(np.int64)
    return stamps


def sample_number(stamp: int, sample_time: float) -> int:
    """Return the number of the sample nearest to a stamp, the inverse of `stamp_ns`.

    Args:
        stamp: Simulated time [ns].
        sample_time: T [s].

    Returns:
        k, negative before the start.
    """
    return round((stamp - START_NS) / (sample_time * 1e9))


def stamp_of(payload: bytes | memoryview) -> int:
    """Read header.stamp of any message that begins with a std_msgs/Header; called for every message of the loop.

    Args:
        payload: Serialised message.

    Returns:
        Stamp [ns].

    Raises:
        MessageError: The message is too short to hold a stamp.
    """
    try:
        sec, nanosec = _LITTLE_ENDIAN(payload) if payload[1] & 1 else _BIG_ENDIAN(payload)
    except (struct.error, IndexError) as error:
        raise MessageError(f"a message of {len(payload)} bytes has no header.stamp") from error
    stamp: int = sec * NANOSECONDS + nanosec
    return stamp


def stamp_of_message(message: Any) -> int:
    """Return header.stamp of a message object [ns]."""
    stamp = message.header.stamp
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)
