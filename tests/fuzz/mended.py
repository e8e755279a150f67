"""Faults that fuzzing and hostile inputs have shown: the input in `HOSTILE`, and what came of it before."""

from __future__ import annotations

MENDED: dict[str, str] = {
    "robot: merges of merges": "no answer within 20 s (any YAML file)",
    "robot: tag without a value": "IndexError (any YAML file)",
    "setting: deep lists": "RecursionError",
    "effect: text that clears the screen": "the terminal obeyed; likewise names in logs, tables and messages",
    "definition: parentheses": "no answer within 20 s; each level took 60 times as long",
    "definition: brackets": "no answer within 20 s; each level took twice as long",
    "definition: large shift": "all memory",
    "definition: 4 G texts": "all memory",
    "log: types in types": "no answer within 20 s; each level took twice as long",
    "log: damaged chunks without number": "a warning for each of 200 000",
    "metadata: one file many times": "read as often as listed",
    "csv: line of 8 MB": "no answer within 20 s",
    "csv: cell of 200 kB": "csv.Error",
    "numpy: damaged packed data": "zlib.error",
    "numpy: archive that expands to 100 MB": "unpacked, however large",
    "numpy: array of 8 PB": "MemoryError",
    "matlab: cells in cells": "the process ended (stack of SciPy), by a file of 28 kB",
    "matlab: variable that expands to 100 MB": "unpacked, however large",
    "hdf5: array of 8 TB": "MemoryError",
    "hdf5: array that expands": "unpacked, however large",
    "hdf5: array in another file": "the other file was read",
    "responses: file that is cut off": "IndexError",
    "responses: name that is damaged": "KeyError",
    "calibration: deep lists": "RecursionError",
    "experiment_state: deep lists": "RecursionError",
    "experiment_state: number as text": "taken, and TypeError in the recorder later",
}
