"""Scheduling of the reference chunks that are streamed ahead of the loop."""

from __future__ import annotations


class ChunkStream:
    """Divides samples 0 to n - 1 into fixed chunks and keeps a lead ahead of the loop.

    Chunks begin at multiples of their length, so that a repeated chunk is the same message. They arrive in the order in
    which they are sent, so unconfirmed chunks before a confirmed one were lost.

    Args:
        n_samples: Number of samples of the reference.
        chunk: Samples in a chunk.
        lead: Least number of samples sent ahead of the loop.

    Attributes:
        sent: Number of samples sent so far.
        resends: Repeated chunks.
    """

    def __init__(self, n_samples: int, chunk: int, lead: int) -> None:
        self.sent = 0
        self.resends = 0
        self._n_samples = n_samples
        self._chunk = chunk
        self._lead = lead
        self._confirms = False
        self._n_sent = self._n_sent_at_check = 0
        self._open: dict[int, int] = {}  # first sample of an unconfirmed chunk: number of its last transmission

    def due(self, progress: int) -> list[range]:
        """Return the chunks to send now.

        Args:
            progress: Newest known sample of the loop.

        Returns:
            Sample numbers of each chunk, in order.
        """
        chunks = []
        while self.sent < self._n_samples and self.sent <= progress + self._lead:
            chunk = self._range(self.sent)
            chunks.append(chunk)
            self._register(chunk.start)
            self.sent = chunk.stop
        return chunks

    def confirm(self, first: int) -> list[range]:
        """Register that a chunk has arrived.

        Args:
            first: Its first sample.

        Returns:
            Sample numbers of each chunk to repeat: sent before this one and unconfirmed.
        """
        self._confirms = True
        return self._resent(self._open.pop(first, 0))

    def overdue(self, progress: int) -> list[range]:
        """Return the chunks to repeat: those sent before the previous call and still unconfirmed.

        There are none until a chunk is confirmed for the first time: not every controller confirms.

        Args:
            progress: Newest known sample of the loop; chunks it has passed are dropped.

        Returns:
            Sample numbers of each chunk.
        """
        self._open = {first: number for first, number in self._open.items() if self._range(first).stop > progress}
        chunks = self._resent(self._n_sent_at_check + 1) if self._confirms else []
        self._n_sent_at_check = self._n_sent
        return chunks

    def since(self, progress: int) -> list[range]:
        """Return the chunks that a stalled loop may lack: all that were sent from its progress on.

        Args:
            progress: Newest known sample of the loop; beyond the sent samples the result is empty.

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
            self._register(chunk.start)
        self.resends += len(chunks)
        return chunks

    def _register(self, first: int) -> None:
        self._n_sent += 1
        self._open[first] = self._n_sent

    def _range(self, first: int) -> range:
        return range(first, min(first + self._chunk, self._n_samples))
