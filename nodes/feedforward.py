"""Feedforward node: streams the motor reference ahead of the loop, and the tool reference."""

from __future__ import annotations

from flexros_nodes.shell.executable import run_node
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.prepared_run import prepared_run
from flexros_nodes.shell.reference_stream import ReferenceStream


class FeedforwardNode(FlexrosNode):
    """Streams the reference of a scenario; see `ReferenceStream`."""

    node_name = "feedforward"

    def configure(self) -> None:
        """Compute the reference; create publishers and the subscription to the clock."""
        self._stream = ReferenceStream(self, prepared_run(self.value("scenario")))

    def start(self) -> None:
        """Search for the subscribers; the first chunks are sent once they are connected."""
        self._stream.start()

    def figures(self) -> dict[str, float]:
        """Return counts of sent and repeated messages."""
        return self._stream.figures()


def main() -> int:
    """Run the node in this process."""
    return run_node(FeedforwardNode)


if __name__ == "__main__":
    raise SystemExit(main())
