"""Input limits for untrusted files and messages, against exhaustion of memory or time.

Each is chosen far above observed use; `docs/reference/limits.md` lists them. Content beyond a limit is omitted with a
warning where the rest can be read, and refused with one sentence otherwise.
"""

from __future__ import annotations

LARGEST_TEXT = 2**20
"""YAML or JSON file [byte]: the metadata.yaml of a log of a thousand files has a quarter; reading takes about 10 s."""
MOST_NODES = 200_000
"""Values in a YAML file with aliases expanded [1]; nested aliases multiply."""
DEEPEST_NODE = 60
"""Levels of lists and mappings in a YAML file [1]."""
LARGEST_JSON = 200 * 2**20
"""Log as JSON [byte]: reading takes some 10 times as much memory."""
LARGEST_URDF = 10 * 2**20
"""URDF, MJCF or SDF file [byte]; meshes are files of their own."""
LARGEST_MESH = 100 * 2**20
"""Mesh of a URDF that the viewer draws [byte]; those of robot makers have up to 20 MB."""

EXPANSION = 200
"""Unpacked content relative to the size of its file [1]; a robot at rest has 9..."""
EXPANSION_ALLOWANCE = 16 * 2**20
"""... plus this allowance for small files [byte]."""
LARGEST_CHUNK = 64 * 2**20
"""Chunk of an MCAP file, unpacked [byte]; common recorders write about 1 MB."""
MOST_DEFINITIONS = 10_000
"""Distinct Schema and Channel records in an MCAP file [1]..."""
LARGEST_DEFINITIONS = 4 * 2**20
"""... and their total size [byte]; the largest of the common types has 4 kB."""

LARGEST_DEFINITION = 2**16
"""Definition of one message type with all nested types [byte]."""
MOST_FIELDS = 2000
"""Fields in it, with the entries of its fixed-length arrays unless of numbers [1]: code is generated for each."""
DEEPEST_TYPE = 20
"""Levels of nested types [1]."""
LARGEST_MESSAGE = 2**20
"""Message decoded by the definition in its file [byte]; every entry becomes an object, many times as large."""
MOST_LAYOUTS = 10_000
"""Distinct layouts (names, frames, lengths) of the messages of one topic [1]; a sender has one or two."""

MOST_ENTRIES = 1000
"""Entries of a list that is split into signals [1]; a longer one is an image or a map."""
MOST_SIGNALS = 100_000
"""Signals of a message, or columns of a file [1]."""
LONGEST_LINE = 2**20
"""Line of a text table [byte]."""
DEEPEST_STRUCTURE = 20
"""Levels of structures and cells in a MATLAB file [1]."""
MOST_ELEMENTS = 100_000
"""Arrays, structures and cells in a MATLAB file [1]."""

MOST_WARNINGS = 20
"""Warnings of one kind that are reported individually [1]; the others are counted."""
LONGEST_SENTENCE = 2000
"""Error or warning [characters]; the middle of a longer one is omitted."""


def room_of(n_bytes: int) -> int:
    """Return the largest total size of the unpacked content of a file [byte].

    Args:
        n_bytes: Size of the file [byte].

    Returns:
        The size [byte].
    """
    return EXPANSION_ALLOWANCE + EXPANSION * n_bytes
