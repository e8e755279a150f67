"""Inputs that were made to take memory, time or the process: claims, bombs, depth without end, code in data."""

from __future__ import annotations

import io
import json
import pickle
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping

import numpy as np
import zstandard

from flexros.logs.mcap.file_writer import MAGIC
from tests.fuzz import samples
from tests.fuzz.samples import CHANNEL, CHUNK, MESSAGE, SCHEMA, chunk_bytes, record_bytes

MANY = 200_000
SEPARATOR = "=" * 80 + "\nMSG: x/T{}\n"


def log_of(*records: bytes) -> bytes:
    """A file of our own with further records behind its magic."""
    own = samples.own_mcap()
    return own[: len(MAGIC)] + b"".join(records) + own[len(MAGIC) :]


def _text(text: bytes) -> bytes:
    return struct.pack("<I", len(text)) + text


def _schema(number: int, name: str, definition: str) -> bytes:
    content = struct.pack("<H", number) + _text(name.encode()) + _text(b"ros2msg") + _text(definition.encode())
    return record_bytes(SCHEMA, content)


def _channel(number: int, schema: int, topic: bytes) -> bytes:
    return record_bytes(CHANNEL, struct.pack("<HH", number, schema) + _text(topic) + _text(b"cdr") + _text(b""))


def _message(channel: int, payload: bytes, time: int = 10**9) -> bytes:
    return record_bytes(MESSAGE, struct.pack("<HIQQ", channel, 0, time, time) + payload)


def _chunk(records: bytes, **options: object) -> bytes:
    return record_bytes(CHUNK, chunk_bytes(records, **options))  # type: ignore[arg-type]


def _bomb_without_size() -> bytes:
    """A zstd frame of 400 MB that does not say how large it is, in a chunk that claims 60 MB."""
    packer = zstandard.ZstdCompressor(write_content_size=False).compressobj()
    packed = b"".join(packer.compress(bytes(2**22)) for _ in range(100)) + packer.flush()
    head = struct.pack("<QQQII", 0, 0, 60 * 2**20, 0, 4) + b"zstd" + struct.pack("<Q", len(packed))
    return record_bytes(CHUNK, head + packed)


def _doubling_types(levels: int) -> str:
    """Each type holds the next one twice."""
    return "".join(f"x/T{k} a\nx/T{k} b\n" + SEPARATOR.format(k) for k in range(levels)) + "int32 z\n"


def _states(names: Callable[[int], tuple[str, ...]], n: int) -> Iterator[bytes]:
    for k in range(n):
        yield _message(2, samples.joint_state(10**9 + k, names(k), position=range(len(names(k)))))


def _foreign_states(*messages: bytes, definition: str = "") -> bytes:
    """A file of another recorder with these Message records on joint_states."""
    text = definition or samples.STORE.generate_msgdef("sensor_msgs/msg/JointState", ros_version=2)[0]
    schema = _schema(2, "sensor_msgs/msg/JointState", text)
    return b"".join([MAGIC, _chunk(b"".join([schema, _channel(2, 2, b"/joint_states"), *messages]))])


def _laughs(form: str, levels: int) -> bytes:
    lines = ["a0: &a0 {k: 1, l: 2}"]
    lines += [f"a{k}: &a{k} " + form.replace("*", f"*a{k - 1}") for k in range(1, levels)]
    return "\n".join(lines).encode()


def _numpy_archive(name: str, content: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return stream.getvalue()


def _npy(shape: str, data: bytes = b"", kind: str = "'<f8'") -> bytes:
    head = f"{{'descr': {kind}, 'fortran_order': False, 'shape': {shape}}}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + data


class _Code:
    """Says so when it is unpickled."""

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str]]:
        return exec, ("raise SystemExit('code in the data was run')",)


def _matlab(data: bytes, kind: int = 15) -> bytes:
    packed = zlib.compress(data) if kind == 15 else data
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x100) + b"IM"
    return head + struct.pack("<II", kind, len(packed)) + packed


def _cells(levels: int) -> bytes:
    """A cell in a cell in a cell."""
    head = struct.pack("<IIIIIIIIiiII", 14, 0x7FFFFFFF, 6, 8, 1, 0, 5, 8, 1, 1, 1, 0)
    return head * levels + struct.pack("<II", 14, 0)


def _overwritten(data: bytes, place: int) -> bytes:
    return data[:place] + b"\xff" * 10 + data[place + 10 :]


def _double(n_bytes: int, data: bytes = b"", kind: int = 9) -> bytes:
    """A matrix of doubles that claims a size, and a type of its element."""
    shape = struct.pack("<IIII", 5, 8, n_bytes // 8, 1)
    body = (
        struct.pack("<IIII", 6, 8, 6, 0) + shape + struct.pack("<IIc7x", 1, 1, b"q") + struct.pack("<II", kind, n_bytes)
    )
    return struct.pack("<II", 14, len(body) + n_bytes) + body + data


def _hdf5(**options: object) -> bytes:
    import h5py

    stream = io.BytesIO()
    with h5py.File(stream, "w", userblock_size=512) as file:
        file.create_dataset("q", dtype="f8", **options)
    return stream.getvalue()


def _everywhere(message: bytes) -> Iterator[bytes]:
    """A message with a count of 4 G in each place where one may stand."""
    for place in range(4, len(message) - 3, 4):
        yield message[:place] + b"\xff\xff\xff\xff" + message[place + 4 :]


def _messages(name: str, *messages: bytes) -> dict[str, tuple[str, Callable[[], bytes]]]:
    variants = [variant for message in messages for variant in _everywhere(message)]
    return {f"{name}: count of 4 G, {k}": (name, lambda data=data: data) for k, data in enumerate(variants)}  # type: ignore[misc]


def _huge_topic() -> bytes:
    return log_of(_schema(99, "x/msg/X", "int32 x\n"), _channel(99, 99, b"/\x1b[2J\n" + b"t" * 10**6))


_IDL = "x/msg/X\nros2idl\nmodule x {{ module msg {{ {} struct X {{ double q; {} }}; }}; }};"
_MSG = "x/msg/X\nros2msg\n"
_LAUGHS = {
    "aliases of aliases": lambda: _laughs("[*, *, *, *, *, *, *, *, *, *]", 12),
    "merges of merges": lambda: _laughs("{<<: [*, *], k: 1}", 40),
    "alias of itself": lambda: b"a: &a [*a]",
    "deep lists": lambda: b"a: " + b"[" * 500 + b"]" * 500,
    "deep mappings": lambda: b"".join(b" " * k + b"a:\n" for k in range(300)),
    "two megabytes": lambda: b"a: " + b"x" * 2**21,
    "number of 100 000 digits": lambda: b"a: " + b"9" * 100_000,
    "objects of Python": lambda: b"a: !!python/object/apply:os.system ['exit 1']",
}
HOSTILE: Mapping[str, tuple[str, Callable[[], bytes]]] = {
    **{f"robot: {name}": ("robot", made) for name, made in _LAUGHS.items()},
    "scenario: aliases of aliases": ("scenario", _LAUGHS["aliases of aliases"]),
    "mapping: alias of itself": ("mapping", _LAUGHS["alias of itself"]),
    "log: record of 2^63 bytes": ("log", lambda: log_of(record_bytes(CHUNK, b"x", 2**63))),
    "log: chunk of 4 GB": ("log", lambda: log_of(_chunk(b"x" * 99, size=2**32))),
    "log: chunk that expands without end": ("log", lambda: log_of(_bomb_without_size())),
    "log: chunks that expand to 6 GB": ("log", lambda: log_of(*[_chunk(_message(9, bytes(60 * 2**20)))] * 100)),
    "log: lz4 chunks that expand": ("log", lambda: log_of(*[_chunk(_message(9, bytes(9**7)), compression="lz4")] * 50)),
    "log: damaged chunks without number": ("log", lambda: log_of(record_bytes(CHUNK, b"") * MANY)),
    "log: empty messages without number": ("log", lambda: log_of(record_bytes(MESSAGE, b"") * 2 * MANY)),
    "log: definitions without number": ("log", lambda: log_of(*(_channel(k % 65536, k, b"/t") for k in range(50_000)))),
    "log: long topic that clears the screen": ("log", _huge_topic),
    "log: types in types": (
        "log",
        lambda: _foreign_states(_message(2, samples.joint_state()), definition=_doubling_types(40)),
    ),
    "log: new names in every message": ("log", lambda: _foreign_states(*_states(lambda k: (f"j{k:06}",), 11_000))),
    "log: names that come twice": ("log", lambda: _foreign_states(*_states(lambda k: ("a", "a", "b"), 5))),
    "replay: topic that clears the screen": ("replay", _huge_topic),
    "bag: damaged chunks without number": ("bag", lambda: log_of(record_bytes(CHUNK, b"") * MANY)),
    "definition: parentheses": ("definition", lambda: _IDL.format("const long N = ((((((1))))));", "").encode()),
    "definition: brackets": (
        "definition",
        lambda: _IDL.format("", "sequence<" * 30 + "long" + ">" * 30 + " u;").encode(),
    ),
    "definition: large shift": ("definition", lambda: _IDL.format("const long N = 1 << 99999999999;", "").encode()),
    "definition: 4 G texts": ("definition", lambda: (_MSG + "string[4000000000] x\n").encode()),
    "definition: arrays of nothing": (
        "definition",
        lambda: (_MSG + "T0[] y\n" + SEPARATOR.format(0) + "int8[0] q\n").encode(),
    ),
    "definition: types in types": ("definition", lambda: (_MSG + _doubling_types(40)).encode()),
    "definition: type in itself": ("definition", lambda: (_MSG + "X a\n").encode()),
    "definition: 100 000 fields": ("definition", lambda: (_MSG + "int8 a\n" * 100_000).encode()),
    "metadata: one file many times": (
        "metadata",
        lambda: (
            b"rosbag2_bagfile_information: {storage_identifier: mcap, relative_file_paths: ["
            + b"bag_0.mcap, " * 2_000
            + b"]}"
        ),
    ),
    "metadata: aliases of aliases": ("metadata", _LAUGHS["aliases of aliases"]),
    "provenance: deep lists": ("provenance", lambda: b"[" * 10**5),
    "provenance: two megabytes": ("provenance", lambda: json.dumps("x" * 2**21).encode()),
    "csv: line of 8 MB": ("csv", lambda: b"t," * 2**22),
    "csv: cell of 200 kB": ("csv", lambda: b't,q,"' + b"x" * MANY + b'"\n1,2,3\n'),
    "csv: no text": ("csv", lambda: b"t,q\n1,2\n\xff,3\n"),
    "numpy: archive that expands to 100 MB": ("numpy", lambda: _numpy_archive("t.npy", bytes(10**8))),
    "numpy: array of 8 PB": ("numpy", lambda: _numpy_archive("t.npy", _npy("(1000000000000000,)"))),
    "numpy: entries of no size": ("numpy", lambda: _numpy_archive("t.npy", _npy("(1000000000000000,)", kind="'|V0'"))),
    "numpy: code in an object": ("numpy", lambda: _numpy_archive("t.npy", _npy("(1,)", pickle.dumps(_Code()), "'|O'"))),
    "numpy: columns without number": (
        "numpy",
        lambda: _numpy_archive("m.npy", _npy("(2, 500000)", bytes(8 * 10**6))),
    ),
    "matlab: cells in cells": ("matlab", lambda: _matlab(_cells(MANY))),
    "matlab: cells in cells, not packed": ("matlab", lambda: _matlab(_cells(20_000), 14)),
    "matlab: variable that expands to 100 MB": ("matlab", lambda: _matlab(_double(10**8, bytes(10**8)))),
    "matlab: element of an unknown type": ("matlab", lambda: _matlab(_double(16, bytes(16), kind=0x809))),
    "matlab: array of 4 GB": ("matlab", lambda: _matlab(_double(2**32 - 256))),
    "matlab: variable of 4 GB": ("matlab", lambda: _matlab(b"")[:-12] + struct.pack("<II", 14, 2**32 - 8)),
    "hdf5: array of 8 TB": ("hdf5", lambda: _hdf5(shape=(10**12,), chunks=(1000,))),
    "hdf5: array that expands": ("hdf5", lambda: _hdf5(data=np.zeros(10**7), compression="gzip")),
    "hdf5: array in another file": ("hdf5", lambda: _hdf5(shape=(10,), external=[("/dev/zero", 0, 80)])),
    "urdf: entities of entities": (
        "urdf",
        lambda: b'<!DOCTYPE r [<!ENTITY a "x"><!ENTITY b "' + b"&a;" * 1000 + b'">]><robot name="&b;"/>',
    ),
    "urdf: deep elements": ("urdf", lambda: b"<robot>" + b"<a>" * MANY + b"</a>" * MANY + b"</robot>"),
    "urdf: 20 MB": ("urdf", lambda: b"<robot>" + b" " * 20 * 2**20 + b"</robot>"),
    "robot: tag without a value": ("robot", lambda: b"!!float "),
    "numpy: damaged packed data": ("numpy", lambda: _overwritten(samples.npz_archive(), 46)),
    "responses: file that is cut off": ("responses", lambda: samples.netcdf_file()[:400]),
    "responses: name that is damaged": ("responses", lambda: samples.netcdf_file().replace(b"gears", b"fears")),
    "effect: text that clears the screen": ("effect", lambda: b"\x1b[2J@tool:relative=1"),
    "setting: deep lists": ("setting", lambda: b"a=" + b"[" * 500),
    "setting: aliases of aliases": ("setting", lambda: b"a=\n" + _laughs("[*, *, *, *, *, *, *, *, *, *]", 12)),
    "experiment_state: deep lists": ("experiment_state", lambda: samples.text_message("[" * 10**5)),
    "experiment_state: number as text": (
        "experiment_state",
        lambda: samples.text_message(json.dumps({**samples.EXPERIMENT_STATE, "stopped_at_sample": "5"})),
    ),
    "experiment_state: number beyond a float": (
        "experiment_state",
        lambda: samples.text_message(json.dumps({**samples.EXPERIMENT_STATE, "percent": 10**400})),
    ),
    "patch: robot with a long name": ("patch", lambda: b"{robot: " + b"x" * 3000 + b", effects: []}"),
    "scenario: robot with a long name": ("scenario", lambda: b"{robot: " + b"x" * 3000 + b".yaml, duration: 1}"),
    "metadata: file with a long name": (
        "metadata",
        lambda: b"rosbag2_bagfile_information: {storage_identifier: mcap, relative_file_paths: [" + b"x" * 3000 + b"]}",
    ),
    "topics: list as QoS": ("topics", lambda: b"joint_states: {type: sensor_msgs/msg/JointState, qos: [loop]}"),
    "recorded: stamp before 1970": ("recorded", lambda: samples.joint_state(-(10**9))),
    "calibration: deep lists": ("calibration", lambda: b"[" * 10**5),
    "case: deep lists": ("case", lambda: b"[" * 10**5),
    **_messages("joint_state", samples.joint_state(position=(1, 2), effort=(3, 4))),
    **_messages("trajectory", samples.trajectory(velocities=True)),
    **_messages("diagnostics", samples.diagnostics()),
    **_messages("pose", samples.pose()),
}
"""Name of the reader and what makes the input, by what it is."""
