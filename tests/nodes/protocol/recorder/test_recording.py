"""Recording of messages."""

from __future__ import annotations

from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.stamps import stamp_ns
from flexros_nodes.protocol.recorder.recording import ArrivalTime, EventRecording, TopicRecording

T = 5e-4
TEMPLATE = JointStateTemplate(("motor_1",), position=True)


class Sink:
    """Keeps the written messages."""

    def __init__(self) -> None:
        self.messages: list[tuple[int, int, int, bytes]] = []

    def write(self, topic_id: int, log_time_ns: int, publish_time_ns: int, payload: bytes) -> None:
        self.messages.append((topic_id, log_time_ns, publish_time_ns, payload))


def message(k: int) -> bytes:
    return TEMPLATE.fill(stamp_ns(k, T), position=[float(k)])


def test_messages_are_written_at_their_stamp() -> None:
    sink = Sink()
    TopicRecording(sink, 3).take(message(7))
    assert sink.messages == [(3, stamp_ns(7, T), stamp_ns(7, T), message(7))]


def test_log_time_in_real_time_is_the_time_of_arrival() -> None:
    sink, now = Sink(), [50.0]
    arrival = ArrivalTime(lambda: now[0])
    recording, events = TopicRecording(sink, 1, arrival), EventRecording(sink, 2, arrival)
    events.take(message(0))  # before the first sample
    arrival.begin()
    recording.take(message(0))
    now[0] += 0.0007
    arrival.begin()
    recording.take(message(1))
    now[0] += 0.001
    events.take(message(1))
    assert [entry[1] for entry in sink.messages] == [10**9, 10**9, 1_000_700_000, 1_001_700_000]
    assert [entry[2] for entry in sink.messages] == [stamp_ns(k, T) for k in (0, 0, 1, 1)]


def test_repeats_and_older_messages_are_left_out() -> None:
    sink = Sink()
    recording = TopicRecording(sink, 1)
    for k in (0, 1, 1, 0, 2):
        recording.take(message(k))
    assert [entry[3] for entry in sink.messages] == [message(k) for k in (0, 1, 2)]
    assert (recording.count, recording.repeated) == (3, 2)


def test_gaps_are_counted() -> None:
    recording = TopicRecording(Sink(), 1)
    assert recording.missing(T) == 0
    for k in (2, 3, 6, 7):
        recording.take(message(k))
    assert recording.missing(T) == 2


def test_events_may_share_a_stamp() -> None:
    sink = Sink()
    recording = EventRecording(sink, 2)
    recording.take(message(5))
    recording.take(message(5))
    assert recording.count == len(sink.messages) == 2


def test_stamp_far_ahead_is_left_out_when_the_loop_does_not_go_on_there() -> None:
    sink = Sink()
    recording = TopicRecording(sink, 1)
    for k in (0, 1, 10**8, 2, 10**7, 3):
        recording.take(message(k))
    assert [entry[3] for entry in sink.messages] == [message(k) for k in (0, 1, 2, 3)]
    assert (recording.count, recording.doubted, recording.repeated) == (4, 2, 0)
    assert recording.missing(T) == 0


def test_late_recorder_keeps_all_later_messages() -> None:
    sink = Sink()
    recording = TopicRecording(sink, 1)
    for k in (10**6, 10**6 + 1, 10**6 + 2):
        recording.take(message(k))
    assert [entry[3] for entry in sink.messages] == [message(k) for k in (10**6, 10**6 + 1, 10**6 + 2)]
    assert (recording.first, recording.count, recording.doubted) == (stamp_ns(10**6, T), 3, 0)


def test_log_time_of_an_event_of_another_time_is_the_present() -> None:
    sink = Sink()
    recording = EventRecording(sink, 2, present=lambda: stamp_ns(5, T))
    recording.take(message(4))
    recording.take(message(10**10))
    recording.take(message(-3000))  # 0.5 s before 1970, which the file cannot hold
    assert [entry[1] for entry in sink.messages] == [stamp_ns(4, T), stamp_ns(5, T), stamp_ns(5, T)]
    assert all(time >= 0 for entry in sink.messages for time in entry[1:3])


def test_stamp_before_the_start_is_left_out() -> None:
    sink = Sink()
    recording = TopicRecording(sink, 1)
    for k in (-3, 0, -1, 1):
        recording.take(message(k))
    assert [entry[3] for entry in sink.messages] == [message(k) for k in (0, 1)]
    assert (recording.doubted, recording.repeated) == (2, 0)
