"""Thread that assembles, compresses and writes chunks while the caller collects messages."""

from __future__ import annotations

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from flexros.logs.mcap.chunk import assemble_chunk

if TYPE_CHECKING:
    from collections.abc import Sequence
    from concurrent.futures import Future

    from flexros.arrays import IntArray
    from flexros.logs.mcap.file_writer import McapFileWriter

_MAX_WAITING = 4  # chosen: chunks in memory while the disk is busy


class ChunkThread:
    """Writer of chunks in the order in which they are submitted.

    Args:
        file: Their file; nothing else may write to it while chunks are pending.
    """

    def __init__(self, file: McapFileWriter) -> None:
        self._file = file
        self._waiting: deque[Future[None]] = deque()
        self._executor = ThreadPoolExecutor(1, "log_writer")

    def write(self, channel: IntArray, log_time: IntArray, publish_time: IntArray, payloads: Sequence[bytes]) -> None:
        """Submit a chunk; wait only if several are pending. Arguments as in `assemble_chunk`.

        Raises:
            OSError: An earlier chunk could not be written.
        """
        self._waiting.append(self._executor.submit(self._write, channel, log_time, publish_time, payloads))
        self.wait(_MAX_WAITING)

    def _write(self, channel: IntArray, log_time: IntArray, publish_time: IntArray, payloads: Sequence[bytes]) -> None:
        self._file.append(assemble_chunk(channel, log_time, publish_time, payloads, self._file.counts))

    def wait(self, n_left: int = 0) -> None:
        """Wait until at most `n_left` chunks are pending.

        Raises:
            OSError: A chunk could not be written.
        """
        while self._waiting and (len(self._waiting) > n_left or self._waiting[0].done()):
            self._waiting.popleft().result()

    def stop(self) -> None:
        """Stop the thread; chunks that it has not started are dropped."""
        self._executor.shutdown(cancel_futures=True)
        self._waiting.clear()
