"""Executable of the node controller."""

from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.shell.executable import run_node


def main() -> int:
    """Run the node in this process."""
    return run_node(ControllerNode)


if __name__ == "__main__":
    raise SystemExit(main())
