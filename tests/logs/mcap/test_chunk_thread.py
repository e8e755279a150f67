from __future__ import annotations

import threading

import numpy as np
import pytest

from flexros.logs.mcap.chunk_thread import ChunkThread
from flexros.logs.mcap.file_writer import McapFileWriter


class HeldFile:
    """Takes chunks one by one, when it is let."""

    def __init__(self, fail_at=None):
        self.counts = {}
        self.written = []
        self.released = threading.Semaphore(0)
        self.fail_at = fail_at

    def append(self, chunk):
        self.released.acquire()
        if len(self.written) == self.fail_at:
            raise OSError(28, "No space left on device")
        self.written.append(chunk.start_time)


def hand_over(thread, time):
    times = np.array([time])
    thread.write(np.array([1]), times, times, [b"x"])


def test_chunks_are_written_in_order_without_the_caller_waiting():
    file = HeldFile()
    thread = ChunkThread(file)
    for time in (3, 1, 2):
        hand_over(thread, time)
    assert file.written == []
    file.released.release(3)
    thread.wait()
    assert file.written == [3, 1, 2]
    thread.stop()


def test_caller_waits_when_the_disk_falls_behind():
    file = HeldFile()
    thread = ChunkThread(file)
    for time in range(4):
        hand_over(thread, time)
    fifth = threading.Thread(target=hand_over, args=(thread, 4))
    fifth.start()
    fifth.join(0.05)
    assert fifth.is_alive()
    file.released.release(5)
    fifth.join(10)
    assert not fifth.is_alive()
    thread.wait()
    assert file.written == [0, 1, 2, 3, 4]
    thread.stop()


def test_failure_reaches_the_caller():
    file = HeldFile(fail_at=1)
    thread = ChunkThread(file)
    file.released.release(9)
    hand_over(thread, 0)
    thread.wait()
    hand_over(thread, 1)
    with pytest.raises(OSError, match="No space left"):
        thread.wait()
    thread.stop()


def test_sequence_numbers_go_on_across_chunks(tmp_path):
    from mcap.reader import make_reader

    file = McapFileWriter(tmp_path / "a.mcap")
    file.add_channel("/a", "x/msg/X", "float64 x", {})
    thread = ChunkThread(file)
    for time in range(5):
        hand_over(thread, time)
    thread.wait()
    thread.stop()
    file.finish("rosbag2", {})
    file.close()
    with (tmp_path / "a.mcap").open("rb") as stream:
        assert [m.sequence for _, _, m in make_reader(stream).iter_messages()] == [0, 1, 2, 3, 4]
