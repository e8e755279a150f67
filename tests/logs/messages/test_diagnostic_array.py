from __future__ import annotations

import pytest

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.diagnostic_array import DiagnosticArrayCodec

CODEC = DiagnosticArrayCodec()


@pytest.mark.parametrize("little_endian", [True, False])
def test_what_the_oracle_serialises_is_read(store, diagnostics, little_endian):
    message = diagnostics(("/plant", "done", {"late": "20", "text": ""}), ("/lab/camera_1", "", {}))
    payload = bytes(store.serialize_cdr(message, CODEC.type, little_endian=little_endian))
    plant, camera = CODEC.read(payload)
    assert plant == (1, "/plant", "done", {"late": "20", "text": ""})
    assert camera == (1, "/lab/camera_1", "", {})


def test_no_status_at_all(store, diagnostics):
    assert CODEC.read(bytes(store.serialize_cdr(diagnostics(), CODEC.type))) == ()


def test_values_that_are_no_finite_numbers_are_no_numbers(store, diagnostics):
    message = diagnostics(("plant", "", {"a": "1.5", "b": "warm", "c": "nan", "d": "inf", "e": ""}))
    (status,) = CODEC.read(bytes(store.serialize_cdr(message, CODEC.type)))
    assert status.numbers() == {"a": 1.5}


def test_a_message_that_is_truncated_says_where(store, diagnostics):
    payload = bytes(store.serialize_cdr(diagnostics(("plant", "", {"a": "1"})), CODEC.type))
    for size in range(4, len(payload)):
        with pytest.raises(MessageError, match="a message ends at byte|claims"):
            CODEC.read(payload[:size])


def test_a_claimed_number_of_entries_is_checked_before_it_is_used(store, diagnostics):
    payload = bytearray(store.serialize_cdr(diagnostics(), CODEC.type))
    payload[-4:] = b"\xff\xff\xff\x7f"
    with pytest.raises(MessageError, match="claims 2147483647 entries of status"):
        CODEC.read(bytes(payload))
