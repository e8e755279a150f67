"""Valid inputs, small, from which damaged ones are made."""

from __future__ import annotations

import io
import json
import struct
import tempfile
import zlib
from functools import cache
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import zstandard
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore
from ruamel.yaml import YAML
from scipy.io import savemat

from flexros.identify.frf.files.netcdf import save_responses
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.logs.bag.metadata import METADATA_FILE
from flexros.logs.mcap.file_writer import MAGIC
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log, PoseSeries
from flexros.logs.write_log import write_log
from tests.fuzz.damage import CLAIMS, damaged

CHECKOUT = Path(__file__).parents[2]
NAMES = ("motor_1", "motor_2")
STORE = get_typestore(Stores.ROS2_JAZZY)
HEAD = struct.Struct("<BQ")
CHUNK, SCHEMA, CHANNEL, MESSAGE, DATA_END = 6, 3, 4, 5, 0x0F


def small_log(n: int = 12) -> Log:
    rng = np.random.default_rng(5)
    stamp = stamps_ns(n, 5e-4)

    def draw(width: int = 2) -> np.ndarray:
        return rng.normal(size=(n, width))

    return Log(
        joint_states=JointSeries(stamp, NAMES, position=draw()),
        joint_commands=JointSeries(stamp, NAMES, effort=draw()),
        joint_reference=JointSeries(stamp, NAMES, draw(), draw(), draw()),
        tool_pose=PoseSeries(stamp, "base", draw(3), draw(4)),
        provenance={"scenario": "x", "seed": 1},
    )


@cache
def own_bag() -> dict[str, bytes]:
    """Files of a log of our own, by name."""
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        write_log(small_log(), bag)
        return {path.name: path.read_bytes() for path in bag.iterdir()}


def own_mcap() -> bytes:
    return next(content for name, content in own_bag().items() if name.endswith(".mcap"))


METADATA, PROVENANCE = METADATA_FILE, "provenance.json"


def message(type_name: str, **fields: Any) -> Any:
    """A message of the oracle."""
    return STORE.types[type_name](**fields)


def header(stamp: int = 10**9, frame_id: str = "") -> Any:
    return message(
        "std_msgs/msg/Header",
        stamp=message("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9),
        frame_id=frame_id,
    )


def serialised(made: Any) -> bytes:
    return bytes(STORE.serialize_cdr(made, made.__msgtype__))


def joint_state(stamp: int = 10**9, names: tuple[str, ...] = NAMES, **fields: Any) -> bytes:
    numbers = {key: np.asarray(fields.get(key, ()), float) for key in ("position", "velocity", "effort")}
    return serialised(message("sensor_msgs/msg/JointState", header=header(stamp), name=list(names), **numbers))


def trajectory(n_points: int = 3, **filled: bool) -> bytes:
    def point(k: int) -> Any:
        given = {
            field: np.full(2, 0.1 * k) if filled.get(field, field == "positions") else np.zeros(0)
            for field in ("positions", "velocities", "accelerations", "effort")
        }
        time = message("builtin_interfaces/msg/Duration", sec=0, nanosec=500_000 * k)
        return message("trajectory_msgs/msg/JointTrajectoryPoint", time_from_start=time, **given)

    points = [point(k) for k in range(n_points)]
    return serialised(
        message("trajectory_msgs/msg/JointTrajectory", header=header(), joint_names=list(NAMES), points=points)
    )


def diagnostics() -> bytes:
    pair = message("diagnostic_msgs/msg/KeyValue", key="period", value="0.5")
    status = message(
        "diagnostic_msgs/msg/DiagnosticStatus", level=1, name="/plant", message="ok", hardware_id="x", values=[pair] * 3
    )
    return serialised(message("diagnostic_msgs/msg/DiagnosticArray", header=header(), status=[status] * 2))


def pose() -> bytes:
    position = message("geometry_msgs/msg/Point", x=1.0, y=2.0, z=3.0)
    orientation = message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    both = message("geometry_msgs/msg/Pose", position=position, orientation=orientation)
    return serialised(message("geometry_msgs/msg/PoseStamped", header=header(frame_id="base"), pose=both))


def text_message(text: str) -> bytes:
    return serialised(message("std_msgs/msg/String", data=text))


EXPERIMENT_STATE = {
    "state": "running",
    "recording": True,
    "position": 1,
    "positions": 2,
    "block": 1,
    "blocks": 1,
    "experiment": 1,
    "experiments": 2,
    "completed": 0,
    "planned": 4,
    "percent": 1.0,
    "time_left_s": 3.0,
    "last_sample": 99,
    "stopped_at_sample": -1,
}

DYNAMIC = """std_msgs/Header header
string[] joint_names
InterfaceValue[] interface_values
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: control_msgs/InterfaceValue
string[] interface_names
float64[] values
"""
DYNAMIC_TYPE = "control_msgs/msg/DynamicJointState"
OTHER_JOINT_STATE = (
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat32[2] extra\n" + DYNAMIC[DYNAMIC.index("=") :]
)
IDL = """================================================================================
IDL: x/msg/X
module x { module msg { const long N = 3; struct X { double q; sequence<double> u; string s; }; }; };
"""
DEFINITIONS = (
    (DYNAMIC_TYPE, "ros2msg", DYNAMIC),
    ("sensor_msgs/msg/JointState", "ros2msg", OTHER_JOINT_STATE),
    ("x/msg/X", "ros2idl", IDL),
    ("x/msg/X", "ros2msg", "int32 N=3\nfloat64 q 1.5\nfloat64[<=4] u\nstring<=5 s\nuint8[4] raw\nstring[2] names\n"),
)


@cache
def foreign_bag() -> bytes:
    """A bag of another robot, some messages outside of chunks, one type defined otherwise than in Jazzy."""
    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.LZ4, chunk_size=600)
    writer.start(profile="ros2")
    state = writer.register_schema(
        "sensor_msgs/msg/JointState",
        "ros2msg",
        STORE.generate_msgdef("sensor_msgs/msg/JointState", ros_version=2)[0].encode(),
    )
    other = writer.register_schema(DYNAMIC_TYPE, "ros2msg", DYNAMIC.encode())
    channels = [
        writer.register_channel("/arm/joint_states", "cdr", state),
        writer.register_channel("/dynamic", "cdr", other),
    ]
    for k in range(10):
        stamp = 10**9 + 500_000 * k
        writer.add_message(channels[0], stamp, joint_state(stamp, position=(0.1 * k, 0.2), effort=(1.0, 2.0)), stamp, k)
        writer.add_message(channels[1], stamp + 7, _dynamic(stamp, 0.1 * k), stamp, k)
    writer.finish()
    return stream.getvalue()


def _dynamic(stamp: int, value: float) -> bytes:
    from rosbags.typesys import get_types_from_msg

    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(DYNAMIC, DYNAMIC_TYPE))
    types = store.types
    time = types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
    values = types["control_msgs/msg/InterfaceValue"](["position", "effort"], np.array([value, 2 * value]))
    made = types[DYNAMIC_TYPE](types["std_msgs/msg/Header"](time, "x"), ["motor_1"], [values])
    return bytes(store.serialize_cdr(made, DYNAMIC_TYPE))


def records_of(data: bytes) -> list[tuple[int, bytes]]:
    """Records of a file or of a chunk that is not compressed, up to the end of the data part."""
    records, position = [], 0
    while position + HEAD.size <= len(data):
        opcode, length = HEAD.unpack_from(data, position)
        if opcode == DATA_END:
            break
        start = position + HEAD.size
        records.append((opcode, data[start : start + length]))
        position = start + length
    return records


def record_bytes(opcode: int, content: bytes, claim: int | None = None) -> bytes:
    return HEAD.pack(opcode, len(content) if claim is None else claim) + content


def chunk_bytes(records: bytes, compression: str = "zstd", size: int | None = None) -> bytes:
    """A Chunk record's content with the right checksum."""
    packed: bytes = {"zstd": zstandard.compress, "lz4": lz4.frame.compress, "": bytes}[compression](records)
    name = compression.encode()
    head = struct.pack("<QQQII", 0, 0, len(records) if size is None else size, zlib.crc32(records), len(name))
    return head + name + struct.pack("<Q", len(packed)) + packed


@cache
def flat_records() -> tuple[tuple[int, bytes], ...]:
    """Schemas, channels and messages of both bags, out of their chunks."""
    found: list[tuple[int, bytes]] = []
    for data in (own_mcap(), foreign_bag()):
        for opcode, content in records_of(data[len(MAGIC) :]):
            if opcode == CHUNK:
                compression = content[32 : 32 + struct.unpack_from("<I", content, 28)[0]].decode()
                packed = content[32 + len(compression) + 8 :]
                inner = lz4.frame.decompress(packed) if compression == "lz4" else zstandard.decompress(packed)
                found += records_of(inner)
            elif opcode in (SCHEMA, CHANNEL):
                found.append((opcode, content))
    return tuple(found)


@st.composite
def reassembled(draw: st.DrawFn) -> bytes:
    """A file with the records of valid ones in any order, damaged inside or not, in chunks with the right checksums."""
    definitions = [record for record in flat_records() if record[0] != MESSAGE]
    messages = [record for record in flat_records() if record[0] == MESSAGE]
    chosen = [*definitions, *draw(st.lists(st.sampled_from(messages), max_size=20))]
    if draw(st.booleans()):
        chosen = draw(st.permutations(chosen))
    parts = []
    for opcode, content in chosen:
        if not draw(st.integers(0, 9)):
            content = draw(damaged([content or b"x"]))
        claim = draw(st.sampled_from(CLAIMS)) if not draw(st.integers(0, 99)) else None
        parts.append(record_bytes(opcode if draw(st.integers(0, 50)) else draw(st.integers(0, 255)), content, claim))
    whole = [MAGIC, record_bytes(1, struct.pack("<I", 4) + b"ros2" + struct.pack("<I", 0))]
    while parts:
        n = draw(st.integers(1, len(parts)))
        inner, parts = b"".join(parts[:n]), parts[n:]
        compression = draw(st.sampled_from(("zstd", "lz4", "", "none")))
        whole.append(inner if compression == "none" else record_bytes(CHUNK, chunk_bytes(inner, compression)))
    return b"".join([*whole, record_bytes(DATA_END, bytes(4)) if draw(st.booleans()) else b""])


def table() -> dict[str, np.ndarray]:
    return {"t": np.arange(8) * 1e-3, "q": np.linspace(0, 1, 8), "u": np.ones(8)}


def csv_table() -> bytes:
    rows = zip(*table().values(), strict=True)
    return "\n".join([",".join(table()), *(",".join(map(repr, map(float, row))) for row in rows), ""]).encode()


def npz_archive(compressed: bool = True) -> bytes:
    stream = io.BytesIO()
    arrays: dict[str, Any] = {**table(), "m": np.ones((8, 2)), "s": np.zeros(4, [("a", "f8"), ("b", "i4")])}
    (np.savez_compressed if compressed else np.savez)(stream, **arrays)
    return stream.getvalue()


def matlab_file(form: str = "5", compressed: bool = True) -> bytes:
    stream = io.BytesIO()
    more = (
        {}
        if form == "4"
        else {"nested": {"a": np.ones((5, 2)), "text": "abc", "cell": np.array([1, "x"], dtype=object)}}
    )
    savemat(stream, {**table(), **more}, format=form, do_compression=compressed and form == "5")
    return stream.getvalue()


def hdf5_file() -> bytes:
    import h5py

    stream = io.BytesIO()
    with h5py.File(stream, "w", userblock_size=512) as file:
        for name, values in table().items():
            file.create_dataset(name, data=values[:, None], compression="gzip" if name == "q" else None)
    data = bytearray(stream.getvalue())
    data[:19] = b"MATLAB 7.3 MAT-file"
    return bytes(data)


@cache
def netcdf_file() -> bytes:
    """Frequency responses of two motors at three frequencies."""
    rng = np.random.default_rng(3)
    matrices = rng.standard_normal((3, 2, 2)) + 1j * rng.standard_normal((3, 2, 2))
    response = FrequencyResponse(
        frequency=np.arange(1.0, 4.0),
        response=matrices,
        noise_error=None,
        total_error=None,
        input_inverse=matrices,
        degrees_of_freedom=14.0,
        input_names=NAMES,
        output_names=NAMES,
        input_units=("Nm", "Nm"),
        coordinate_units=("rad", "rad"),
        gears=np.zeros(2),
        motor_position=np.zeros(2),
        sample_time=5e-4,
        n_periods=2,
        n_blocks=3,
        distortion=None,
        warnings=("one",),
    )
    with tempfile.TemporaryDirectory() as folder:
        save_responses([response], Path(folder) / "a.nc")
        return (Path(folder) / "a.nc").read_bytes()


MAPPING = {
    "name": "mine",
    "time": {"column": "t", "unit": "s"},
    "columns": [
        {"column": "q", "quantity": "position", "joint": "motor_1", "unit": "rad"},
        {
            "column": "u",
            "quantity": "torque_command",
            "unit": "V",
            "scale": {"value": 2.0, "unit": "Nm/V"},
            "sign": -1,
            "gear_ratio": 10.0,
            "optional": True,
        },
    ],
}
BAG_MAPPING = {
    "name": "bag",
    "columns": [
        {"column": "/arm/joint_states.position[motor_1]", "quantity": "position", "unit": "rad"},
        {
            "column": "/dynamic.interface_values[motor_1].values[effort]",
            "quantity": "measured_torque",
            "unit": "Nm",
            "optional": True,
        },
    ],
}
PATCH = {
    "robot": "two_mass",
    "effects": [{"effect": "stiffness_error", "location": "body_1.rz", "parameters": {"relative": 0.05}}],
}
URDF = b"""<?xml version="1.0"?><robot name="r"><link name="base"/><link name="a"><inertial><mass value="2"/>
<origin xyz="0 0 0.1" rpy="0 0 0"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<link name="tool"/><joint name="j" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 1"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="2"/></joint><joint name="t" type="fixed">
<parent link="a"/><child link="tool"/><origin xyz="0 0 1"/></joint></robot>"""


def trees_of(folder: str) -> list[Any]:
    """Content of the YAML files of a folder of the checkout, as plain data."""
    return [json.loads(json.dumps(YAML(typ="safe").load(path))) for path in sorted((CHECKOUT / folder).glob("*.yaml"))]
