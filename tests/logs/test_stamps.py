from __future__ import annotations

import struct

import numpy as np
import pytest

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.stamps import sample_number, stamp_ns, stamp_of, stamps_ns


def test_simulated_time_starts_at_one_second():
    assert stamp_ns(0, 5e-4) == 1_000_000_000


@pytest.mark.parametrize("sample_time", [5e-4, 1e-3, 1 / 3000, 0.004])
def test_vector_equals_scalar(sample_time):
    assert stamps_ns(5000, sample_time).tolist() == [stamp_ns(k, sample_time) for k in range(5000)]


def test_rounding_does_not_accumulate():
    assert stamp_ns(3000, 1 / 3000) == 2_000_000_000


def test_stamps_are_integers():
    assert stamps_ns(3, 5e-4).dtype == np.int64


@pytest.mark.parametrize("k", [0, 1, 79_999, 10_000_000])
def test_number_of_a_stamp(k):
    assert sample_number(stamp_ns(k, 1 / 3000), 1 / 3000) == k


@pytest.mark.parametrize(("order", "flag"), [("<", 1), (">", 0), ("<", 7), (">", 6)])
@pytest.mark.parametrize("kind", [bytes, memoryview])
def test_stamp_of_a_message_in_either_byte_order(order, flag, kind):
    message = bytes((0, flag, 0, 0)) + struct.pack(f"{order}iI", 12, 345_678_901)
    assert stamp_of(kind(message)) == 12_345_678_901


def test_stamp_of_a_joint_state():
    assert stamp_of(JointStateTemplate(["a"], position=True).fill(12_345_678_901, [1.0])) == 12_345_678_901


@pytest.mark.parametrize("message", [b"", b"\0", b"\0\1\0\0", b"\0\1\0\0" + bytes(7), bytes(11)])
def test_stamp_of_a_stub_is_refused(message):
    with pytest.raises(MessageError, match=f"a message of {len(message)} bytes has no header.stamp"):
        stamp_of(message)
