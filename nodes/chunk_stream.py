"""Which parts of a reference to stream ahead of the loop, free of ROS."""

from __future__ import annotations


class ChunkStream:
    """Cuts samples 0 to n - 1 into fixed chunks and keeps a lead ahead of the loop.

    Chunks always begin at multiples of their length, so that a chunk sent again is the same message.

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

    def due(self, progress: int) -> list[range]:
        """Give the chunks to send now.

        Args:
            progress: Newest sample of the loop that is known.

        Returns:
            Sample numbers of each chunk, in order.
        """
        chunks = []
        while self.sent < self._n_samples and self.sent <= progress + self._lead:
            stop = min(self.sent + self._chunk, self._n_samples)
            chunks.append(range(self.sent, stop))
            self.sent = stop
        return chunks

    def again(self, progress: int) -> list[range]:
        """Give the chunks that a stalled loop may lack: those sent from the progress on.

        Args:
            progress: Newest sample of the loop that is known; one in the future of the sent ones gives no chunk.

        Returns:
            Sample numbers of each chunk, in order.
        """
        first = max(progress, 0) // self._chunk * self._chunk
        chunks = [
            range(start, min(start + self._chunk, self._n_samples)) for start in range(first, self.sent, self._chunk)
        ]
        self.resends += len(chunks)
        return chunks
