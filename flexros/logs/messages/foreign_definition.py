"""Messages whose definition in the file differs from that of ROS 2 Jazzy: decoded by the schema of the file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.errors import InputError
from flexros.input_limits import LARGEST_DEFINITION, LARGEST_MESSAGE
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.definition_parts import PARSERS, parse_definition
from flexros.logs.messages.schemas import message_schema, signature

if TYPE_CHECKING:
    from collections.abc import Callable

    from mcap.records import Schema

    from flexros.logs.messages.codec import AbstractSeriesCodec


def is_common(schema: Schema) -> bool:
    """Return whether a schema of a file serialises like the common definition of its type."""
    text: str = schema.data.decode(errors="replace")
    if schema.encoding != "ros2msg" or len(schema.data) > LARGEST_DEFINITION:
        return False
    common = message_schema(schema.name).text
    try:
        return signature(schema.name, text) == signature(schema.name, common)
    except InputError:
        return False  # the translator reports the reason


def decoder(schema: Schema, source: str) -> Callable[[bytes], Any]:
    """Return a function that decodes messages of any type by the schema in their file.

    Args:
        schema: Schema record of the file.
        source: The file, for error messages.

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
    except Exception as error:  # the errors of the parser have no common base class
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


def translator(codec: AbstractSeriesCodec[Any], schema: Schema, source: str) -> Callable[[bytes], bytes]:
    """Return a function that converts messages of a schema to messages of the common definition.

    Args:
        codec: Codec of the type.
        schema: Schema record of the file.
        source: The file, for error messages.

    Returns:
        Takes a serialised message and returns one; raises MessageError where the message does not fit the schema.

    Raises:
        InputError: The schema cannot be read.
    """
    decode = decoder(schema, source)
    serialise = codec.serialiser()

    def translate(payload: bytes) -> bytes:
        message = decode(payload)
        try:
            return serialise(message)
        except Exception as error:  # a field may be missing, or be of another kind
            raise MessageError(f"it does not fit its definition ({type(error).__name__}: {error})") from error

    return translate
