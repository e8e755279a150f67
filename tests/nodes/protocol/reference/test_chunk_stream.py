"""Schedule of the chunks of a reference."""

from __future__ import annotations

from flexros_nodes.protocol.reference.chunk_stream import ChunkStream


def test_all_samples_are_sent_once_in_order() -> None:
    stream = ChunkStream(n_samples=1050, chunk=100, lead=250)
    sent = [k for progress in range(0, 1050, 20) for chunk in stream.due(progress) for k in chunk]
    assert sent == list(range(1050))


def test_lead_is_kept() -> None:
    stream = ChunkStream(n_samples=10_000, chunk=100, lead=250)
    for progress in (0, 130, 131, 700):
        stream.due(progress)
        assert progress + 250 < stream.sent <= progress + 250 + 100


def test_chunks_of_a_stalled_loop_are_those_it_may_lack() -> None:
    stream = ChunkStream(n_samples=10_000, chunk=100, lead=250)
    stream.due(0)
    stream.due(330)
    assert stream.since(330) == [range(300, 400), range(400, 500), range(500, 600)]
    assert stream.resends == 3


def test_chunk_sent_again_is_the_same_chunk() -> None:
    stream = ChunkStream(n_samples=230, chunk=100, lead=500)
    assert stream.due(0) == stream.since(0) == [range(100), range(100, 200), range(200, 230)]


def test_nothing_is_due_after_the_end() -> None:
    stream = ChunkStream(n_samples=230, chunk=100, lead=500)
    stream.due(0)
    assert stream.due(229) == []
    assert stream.since(400) == []


def test_chunk_is_sent_again_as_soon_as_a_later_one_is_confirmed() -> None:
    stream = ChunkStream(n_samples=1000, chunk=100, lead=250)
    stream.due(0)
    assert stream.confirm(0) == []
    assert stream.confirm(200) == [range(100, 200)]
    assert stream.resends == 1


def test_chunk_that_is_on_its_way_again_is_not_sent_a_third_time() -> None:
    stream = ChunkStream(n_samples=1000, chunk=100, lead=450)
    stream.due(0)
    assert stream.confirm(100) == [range(100)]
    assert stream.confirm(200) == stream.confirm(300) == []  # sent before the first one was sent again
    stream.due(100)
    assert stream.confirm(500) == [range(100), range(400, 500)]


def test_chunk_that_is_not_confirmed_is_overdue_from_the_second_look_on() -> None:
    stream = ChunkStream(n_samples=1000, chunk=100, lead=250)
    stream.due(0)
    stream.confirm(0)
    stream.confirm(100)
    assert stream.overdue(0) == []
    assert stream.overdue(0) == [range(200, 300)]
    assert stream.overdue(150) == [range(200, 300)]
    assert stream.resends == 2
    stream.confirm(200)
    assert stream.overdue(150) == []


def test_chunk_that_the_loop_has_passed_is_not_overdue() -> None:
    stream = ChunkStream(n_samples=1000, chunk=100, lead=250)
    stream.due(0)
    stream.confirm(0)
    stream.overdue(0)
    assert stream.overdue(200) == [range(200, 300)]


def test_nothing_is_overdue_for_a_controller_that_confirms_nothing() -> None:
    stream = ChunkStream(n_samples=1000, chunk=100, lead=250)
    stream.due(0)
    assert stream.overdue(0) == stream.overdue(0) == []


def test_confirmation_of_what_was_never_sent_changes_nothing() -> None:
    stream = ChunkStream(n_samples=1000, chunk=100, lead=250)
    stream.due(0)
    assert [stream.confirm(first) for first in (-100, 50, 10**12)] == [[], [], []]
    stream.overdue(0)
    assert stream.overdue(0) == [range(100), range(100, 200), range(200, 300)]
