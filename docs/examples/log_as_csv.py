"""Write a log as a table of another controller would look: python log_as_csv.py LOG TABLE.csv."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from flexros.logs.reader import read_log


def main() -> None:
    """Write time in ms, angle in degrees and current in A of the first motor."""
    log = read_log(Path(sys.argv[1]))
    states, commands = log.joint_states, log.joint_commands
    if states.position is None or commands is None or commands.effort is None:
        raise SystemExit(f"{sys.argv[1]} lacks positions or torques")
    n = min(len(states.stamp), len(commands.stamp))
    time = (states.stamp[:n] - states.stamp[0]) * 1e-6
    columns = (time, np.rad2deg(states.position[:n, 0]), commands.effort[:n, 0] / 0.25)
    np.savetxt(sys.argv[2], np.column_stack(columns), "%.9g", ",", header="time,angle,current", comments="")


if __name__ == "__main__":
    main()
