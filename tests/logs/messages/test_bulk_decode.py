from __future__ import annotations

import numpy as np

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.message_block import MESSAGE_HEADER, MessageBlock
from flexros.logs.messages import bulk_decode
from flexros.logs.messages.bulk_decode import TopicDecoder
from flexros.logs.messages.joint_state import JointStateTemplate, read_joint_state_layout


def block_of(payloads, gap=b"\xcc" * 5):
    headers = np.zeros(len(payloads), MESSAGE_HEADER)
    headers["length"] = [len(p) + 22 for p in payloads]
    headers["log_time"] = np.arange(len(payloads)) + 100
    offsets = np.cumsum([len(gap)] + [len(p) + len(gap) for p in payloads])[:-1]
    return MessageBlock(gap + gap.join(payloads), headers, offsets)


def decode(payloads, translate=None, n_blocks=1):
    decoder = TopicDecoder(read_joint_state_layout)
    for part in np.array_split(np.arange(len(payloads)), n_blocks):
        decoder.add(block_of([payloads[i] for i in part]), np.arange(len(part)), translate)
    return decoder


def rows(decoder):
    """Stamp and positions by place in the topic."""
    found = {}
    for segment in decoder.segments:
        for order, stamp, position in zip(segment.order, segment.stamp, segment.numbers[0], strict=True):
            found[int(order)] = (int(stamp), tuple(position))
    return found


def test_one_layout_gives_one_segment_per_block():
    template = JointStateTemplate(["a"], position=True)
    decoder = decode([template.fill(k, [k / 2]) for k in range(50)], n_blocks=2)
    assert len(decoder.segments) == 2
    assert decoder.segments[0].layout is decoder.segments[1].layout
    assert rows(decoder) == {k: (k, (k / 2,)) for k in range(50)}


def test_layouts_that_alternate_keep_their_places():
    one, two = JointStateTemplate(["a", "b"], position=True), JointStateTemplate(["b", "a"], position=True)
    three = JointStateTemplate(["long_name"], position=True)
    payloads = [(one, two, three)[k % 3].fill(k, [k] * (1 if k % 3 == 2 else 2)) for k in range(30)]
    decoder = decode(payloads)
    assert len(decoder.segments) == 3
    assert rows(decoder) == {k: (k, (k,) * (1 if k % 3 == 2 else 2)) for k in range(30)}


def test_frame_that_changes_with_every_message():
    payloads = [JointStateTemplate(["a"], position=True, frame_id=f"{k:03d}").fill(k, [k]) for k in range(150)]
    assert rows(decode(payloads)) == {k: (k, (float(k),)) for k in range(150)}


def test_layouts_beyond_the_limit_are_left_out(monkeypatch):
    monkeypatch.setattr(bulk_decode, "MOST_LAYOUTS", 70)
    payloads = [JointStateTemplate(["a"], position=True, frame_id=f"{k:03d}").fill(k, [k]) for k in range(150)]
    decoder = decode(payloads)
    assert sorted(rows(decoder)) == list(range(70))
    assert (decoder.damaged.number, decoder.damaged.first) == (80, "the topic has more than 70 message layouts")


def test_damaged_messages_are_counted_and_the_others_decoded():
    template = JointStateTemplate(["a"], position=True)
    payloads = [template.fill(k, [k]) for k in range(6)]
    payloads[1], payloads[4] = b"", payloads[4][:20]
    decoder = decode(payloads)
    assert sorted(rows(decoder)) == [0, 2, 3, 5]
    assert (decoder.n_messages, decoder.damaged.number) == (6, 2)


def test_translation_of_each_message():
    template = JointStateTemplate(["a"], position=True)

    def translate(payload: bytes) -> bytes:
        if payload == b"3":
            raise MessageError("three is bad")
        return template.fill(int(payload), [int(payload)])

    decoder = decode([str(k).encode() for k in range(5)], translate)
    assert sorted(rows(decoder)) == [0, 1, 2, 4]
    assert (decoder.damaged.number, decoder.damaged.first) == (1, "three is bad")


def test_rows_of_other_topics_are_left_alone():
    template = JointStateTemplate(["a"], position=True)
    decoder = TopicDecoder(read_joint_state_layout)
    decoder.add(block_of([template.fill(k, [k]) for k in range(6)]), np.array([1, 4]))
    assert rows(decoder) == {0: (1, (1.0,)), 1: (4, (4.0,))}
    assert decoder.segments[0].log_time.tolist() == [101, 104]
