from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.messages.joint_state import JointStateTemplate, joint_state_layout, read_joint_state_layout

NAMES = ("a", "motor_2")


def fill_all(stamps, position, effort):
    template = JointStateTemplate(NAMES, position=True, effort=True, frame_id="base")
    return [template.fill(int(s), p, effort=e) for s, p, e in zip(stamps, position, effort, strict=True)]


@pytest.fixture
def drawn():
    rng = np.random.default_rng(0)
    stamps = rng.integers(0, 2**31 * 10**9, 20)
    return stamps, rng.normal(size=(20, 2)), rng.normal(size=(20, 2))


def as_matrix(payloads):
    return np.frombuffer(b"".join(payloads), np.uint8).reshape(len(payloads), -1)


def test_many_at_once_equal_one_by_one(drawn):
    stamps, position, effort = drawn
    layout = joint_state_layout(NAMES, ("position", "effort"), "base").message
    messages = layout.serialise(stamps, [position, np.empty((20, 0)), effort])
    assert [m.tobytes() for m in messages] == fill_all(*drawn)


def test_numbers_of_many_messages(drawn):
    messages = as_matrix(fill_all(*drawn))
    layout = read_joint_state_layout(messages[3].tobytes()).message
    assert layout.matches(messages).all()
    np.testing.assert_array_equal(layout.stamps(messages), drawn[0])
    np.testing.assert_array_equal(layout.numbers(messages, 0), drawn[1])
    assert layout.numbers(messages, 1).shape == (20, 0)
    np.testing.assert_array_equal(layout.numbers(messages, 2), drawn[2])


def test_every_byte_is_stamp_number_padding_or_fixed(drawn):
    """Changing a byte outside of stamp, numbers and padding must break the match, any other must not."""
    payload = fill_all(*drawn)[0]
    layout = read_joint_state_layout(payload).message
    changing = [(4, 12), *((s.offset, s.offset + 8 * s.size) for s in layout.spans), *layout.padding]
    for at in range(len(payload)):
        other = bytearray(payload)
        other[at] ^= 0x55
        free = any(begin <= at < end for begin, end in changing)
        assert layout.matches(as_matrix([bytes(other)]))[0] == free, at


def test_bytes_behind_the_last_member_are_ignored(drawn):
    payloads = fill_all(*drawn)
    layout = read_joint_state_layout(payloads[0] + b"\xaa" * 9).message
    assert layout.image == payloads[0]
    longer = as_matrix([payload + b"\xbb" * 9 for payload in payloads])
    assert layout.matches(longer).all()
    np.testing.assert_array_equal(layout.numbers(longer, 2), drawn[2])


def test_shorter_messages_do_not_match(drawn):
    payloads = fill_all(*drawn)
    assert not read_joint_state_layout(payloads[0]).message.matches(as_matrix([p[:-1] for p in payloads])).any()
