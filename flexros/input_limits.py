"""Limits on what others wrote, so that no file or message takes memory or time hostage.

Each is far above what was seen in use and was chosen; `docs/reference/limits.md` lists them. What is beyond one is left
out with a warning where the rest can be read, and refused with one sentence where not.
"""

from __future__ import annotations

LARGEST_TEXT = 2**20
"""YAML or JSON file [byte]: the metadata.yaml of a log of a thousand files has a quarter; read in ten seconds or so."""
MOST_NODES = 200_000
"""Values in a YAML file, aliases written out [1]; an alias of an alias multiplies."""
DEEPEST_NODE = 60
"""Levels of lists and mappings in a YAML file [1]."""
LARGEST_URDF = 10 * 2**20
"""URDF file [byte]; meshes are files of their own."""

EXPANSION = 200
"""What is packed may altogether be so many times as large as its file [1]; a robot at rest is 9 times..."""
EXPANSION_ALLOWANCE = 16 * 2**20
"""... and this much larger, for small files [byte]."""
LARGEST_CHUNK = 64 * 2**20
"""Chunk of an MCAP file, unpacked [byte]; common recorders write about 1 MB."""
MOST_DEFINITIONS = 10_000
"""Different Schema and Channel records in an MCAP file [1]..."""
LARGEST_DEFINITIONS = 4 * 2**20
"""... and their size altogether [byte]; of the common types the largest has 4 kB."""

LARGEST_DEFINITION = 2**16
"""Definition of one message type with all that it nests [byte]."""
MOST_FIELDS = 2000
"""Fields in it, with the entries of its arrays of fixed length unless of numbers [1]: code is made for each."""
DEEPEST_TYPE = 20
"""Levels of types in types [1]."""
LARGEST_MESSAGE = 2**20
"""Message that is decoded by the definition in its file [byte]; every entry becomes an object, many times as large."""
MOST_LAYOUTS = 10_000
"""Different layouts (names, frames, lengths) of the messages of one topic [1]; a sender has one or two."""

MOST_ENTRIES = 1000
"""Entries of a list that is taken apart into signals [1]; a longer one is a picture or a map."""
MOST_SIGNALS = 100_000
"""Signals of a message, or columns of a file [1]."""
LONGEST_LINE = 2**20
"""Line of a table as text [byte]."""
DEEPEST_STRUCTURE = 20
"""Levels of structures and cells in a MATLAB file [1]."""
MOST_ELEMENTS = 100_000
"""Arrays, structures and cells in a MATLAB file [1]."""

MOST_WARNINGS = 20
"""Warnings of one kind that are told one by one [1]; the others are counted."""
LONGEST_SENTENCE = 2000
"""Error or warning [characters]; the middle of a longer one is left out."""


def room_of(n_bytes: int) -> int:
    """Size that the packed content of a file may have altogether.

    Args:
        n_bytes: Size of the file [byte].

    Returns:
        The size [byte].
    """
    return EXPANSION_ALLOWANCE + EXPANSION * n_bytes
