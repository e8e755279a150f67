"""Executable of the node plant."""

from flexros_nodes.plant.node import PlantNode
from flexros_nodes.shell.executable import run_node


def main() -> int:
    """Run the node in this process."""
    return run_node(PlantNode)


if __name__ == "__main__":
    raise SystemExit(main())
