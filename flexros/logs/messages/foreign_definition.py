"""Messages whose definition in the file differs from that of ROS 2 Jazzy: decoded from the file's own schema."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.errors import InputError
from flexros.input_limits import LARGEST_DEFINITION, LARGEST_MESSAGE
from flexros.logs.messages import joint_state as joint_state_message
from flexros.logs.messages import pose_stamped as pose_stamped_message
from flexros.logs.messages.cdr_cursor import MessageError
from flexros.logs.messages.definition_parts import PARSERS, parse_definition
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.messages.pose_stamped import PoseStampedTemplate
from flexros.logs.messages.schemas import jazzy_types, signature
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Callable

    from mcap.records import Schema


def is_common(schema: Schema) -> bool:
    """Tell whether a schema of a file serialises like the common definition of its type."""
    text: str = schema.data.decode(errors="replace")
    if schema.encoding != "ros2msg" or len(schema.data) > LARGEST_DEFINITION:
        return False
    common, _ = jazzy_types().generate_msgdef(schema.name, ros_version=2)
    try:
        return signature(schema.name, text) == signature(schema.name, common)
    except InputError:
        return False  # the translator names what is wrong with it


def decoder(schema: Schema, source: str) -> Callable[[bytes], Any]:
    """Make a function that decodes messages by the schema in their file, of whatever type.

    Args:
        schema: Schema record of the file.
        source: The file, for error texts.

    Returns:
        Takes a serialised message and returns a dataclass with the fields of the schema; raises MessageError where the
        message does not fit the schema.

    Raises:
        InputError: The schema cannot be read.
    """
    from rosbags.typesys import Stores, get_typestore

    if schema.encoding not in PARSERS:
        raise InputError(
            f"{source}: the definition of {schema.name} is in '{schema.encoding}', allowed are ros2msg and ros2idl"
        )
    store = get_typestore(Stores.EMPTY)
    try:
        store.register(parse_definition(schema))
        store.get_msgdef(schema.name)
    except Exception as error:  # the parser names no base class for its errors
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(
            f"{source}: the definition of {schema.name} cannot be read ({reason}); record it again"
        ) from error

    def decode(payload: bytes) -> Any:
        if len(payload) > LARGEST_MESSAGE:
            raise MessageError(f"it has {len(payload)} bytes, allowed are {LARGEST_MESSAGE}")
        try:
            return store.deserialize_cdr(payload, schema.name)
        except Exception as error:  # a damaged message can fail anywhere in generated code
            raise MessageError(f"it does not fit its definition ({type(error).__name__}: {error})") from error

    return decode


def translator(schema: Schema, source: str) -> Callable[[bytes], bytes]:
    """Make a function that turns messages of a schema into messages of the common definition.

    Args:
        schema: Schema record of the file; its type is JointState or PoseStamped.
        source: The file, for error texts.

    Returns:
        Takes a serialised message and returns one; raises MessageError where the message does not fit the schema.

    Raises:
        InputError: The schema cannot be read.
    """
    decode = decoder(schema, source)
    convert = _CONVERTERS[schema.name]()

    def translate(payload: bytes) -> bytes:
        message = decode(payload)
        try:
            return convert(message)
        except Exception as error:  # a field may be missing, or be of another kind
            raise MessageError(f"it does not fit its definition ({type(error).__name__}: {error})") from error

    return translate


def _joint_state() -> Callable[[Any], bytes]:
    templates: dict[tuple[object, ...], JointStateTemplate] = {}

    def convert(message: Any) -> bytes:
        values = [[float(v) for v in getattr(message, field, ())] for field in joint_state_message.FIELDS]
        key = (message.header.frame_id, tuple(message.name), *(bool(v) for v in values))
        if key not in templates:
            position, velocity, effort = (bool(v) for v in values)
            templates[key] = JointStateTemplate(
                message.name, position=position, velocity=velocity, effort=effort, frame_id=message.header.frame_id
            )
        return templates[key].fill(_stamp(message), *values)

    return convert


def _pose_stamped() -> Callable[[Any], bytes]:
    templates: dict[str, PoseStampedTemplate] = {}

    def convert(message: Any) -> bytes:
        frame_id = message.header.frame_id
        if frame_id not in templates:
            templates[frame_id] = PoseStampedTemplate(frame_id)
        p, o = message.pose.position, message.pose.orientation
        return templates[frame_id].fill(_stamp(message), (p.x, p.y, p.z), (o.x, o.y, o.z, o.w))

    return convert


def _stamp(message: Any) -> int:
    stamp = message.header.stamp
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


_CONVERTERS = {joint_state_message.TYPE: _joint_state, pose_stamped_message.TYPE: _pose_stamped}
