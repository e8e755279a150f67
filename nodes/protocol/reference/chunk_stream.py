"""Which parts of a reference to stream ahead of the loop, free of ROS."""

from __future__ import annotations


class ChunkStream:
    """Cuts samples 0 to n - 1 into fixed chunks and keeps a lead ahead of the loop.

    Chunks always begin at multiples of their length, so that a chunk sent again is the same message. They arrive in the
    order in which they are sent, so one that is confirmed tells of those before it that they were lost.

    Args:
        n_samples: Number of samples of the reference.
        chunk: Samples in a chunk.
        lead: Samples that shall at least be known ahead of the loop.

    Attributes:
        sent: Samples sent so far, from 0.
        resends: Chunks sent again.
    """

    def __init__(self, n_samples: int, chunk: int, lead: int) -> None:
        self.sent = 0
        self.resends = 0
        self._n_samples = n_samples
        self._chunk = chunk
        self._lead = lead
        self._confirms = False
        self._sendings = self._looked = 0
        self._open: dict[int, int] = {}  # first sample of a chunk that is not confirmed: number of its last sending

    def due(self, progress: int) -> list[range]:
        """Give the chunks to send now.

        Args:
            progress: Newest sample of the loop that is known.

        Returns:
            Sample numbers of each chunk, in order.
        """
        chunks = []
        while self.sent < self._n_samples and self.sent <= progress + self._lead:
            chunk = self._range(self.sent)
            chunks.append(chunk)
            self._note(chunk.start)
            self.sent = chunk.stop
        return chunks

    def confirm(self, first: int) -> list[range]:
        """Note that a chunk has arrived.

        Args:
            first: Its first sample.

        Returns:
            Sample numbers of each chunk to send again: sent before this one, and not confirmed.
        """
        self._confirms = True
        return self._resent(self._open.pop(first, 0))

    def overdue(self, progress: int) -> list[range]:
        """Give the chunks to send again that were there at the look before and are not confirmed.

        There are none as long as no chunk was ever confirmed: not every controller does that.

        Args:
            progress: Newest sample of the loop that is known; what it has passed is wanted no more.

        Returns:
            Sample numbers of each chunk.
        """
        self._open = {first: number for first, number in self._open.items() if self._range(first).stop > progress}
        chunks = self._resent(self._looked + 1) if self._confirms else []
        self._looked = self._sendings
        return chunks

    def again(self, progress: int) -> list[range]:
        """Give the chunks that a stalled loop may lack: those sent from the progress on.

        Args:
            progress: Newest sample of the loop that is known; one in the future of the sent ones gives no chunk.

        Returns:
            Sample numbers of each chunk, in order.
        """
        first = max(progress, 0) // self._chunk * self._chunk
        chunks = [self._range(start) for start in range(first, self.sent, self._chunk)]
        self.resends += len(chunks)
        return chunks

    def _resent(self, before: int) -> list[range]:
        chunks = [self._range(first) for first, number in self._open.items() if number < before]
        for chunk in chunks:
            self._note(chunk.start)
        self.resends += len(chunks)
        return chunks

    def _note(self, first: int) -> None:
        self._sendings += 1
        self._open[first] = self._sendings

    def _range(self, first: int) -> range:
        return range(first, min(first + self._chunk, self._n_samples))
