"""Feedforward node: streams the motor reference ahead of the loop, and the tool reference beside it."""

from __future__ import annotations

from flexros_nodes.shell.executable import run_node
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.prepared_run import prepared_run
from flexros_nodes.shell.reference_stream import ReferenceStream


class FeedforwardNode(FlexrosNode):
    """The reference of a scenario, streamed as `ReferenceStream` does it."""

    node_name = "feedforward"

    def configure(self) -> None:
        """Compute the reference; make publishers and the subscription to the clock."""
        self._stream = ReferenceStream(self, prepared_run(self.value("scenario")))

    def start(self) -> None:
        """Look for the readers; the first chunks go out when they are there."""
        self._stream.start()

    def figures(self) -> dict[str, float]:
        """Give what was sent and sent again."""
        return self._stream.figures()


def main() -> int:
    """Run the node as an executable."""
    return run_node(FeedforwardNode)


if __name__ == "__main__":
    raise SystemExit(main())
