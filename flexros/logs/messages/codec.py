"""Contract of a message type: how logs read and write it, and the discovery of all types."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from flexros.discovery import members
from flexros.errors import unknown_name
from flexros.logs.messages.bulk_decode import TopicLayout

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.messages.bulk_decode import Segment
    from flexros.logs.messages.layout import MessageLayout
    from flexros.logs.time_series import Series

M_co = TypeVar("M_co", covariant=True)
L = TypeVar("L", bound=TopicLayout)


class AbstractCodec(ABC, Generic[M_co]):
    """One ROS 2 message type, read from and written to CDR without a message class.

    How to add a type:

    1. Write a file in this package with one final subclass. If one message carries one sample of some signals, derive
       it from `AbstractSeriesCodec`: its topics become time series of a log. Otherwise derive it from `AbstractCodec`.
    2. Set `type` and `sampled`, and implement the abstract methods.
    3. Add the topic to `msgs_config/topics.yaml`, and a test that compares the bytes with those of rosbags.

    Reader, writer and recorder find the class by the type of the topic.

    Attributes:
        type: Message type, e.g. "sensor_msgs/msg/JointState".
        sampled: Whether a topic of this type carries one message per sampling instant; otherwise its messages are
            events, for which the recorder does not wait.
    """

    type: ClassVar[str]
    sampled: ClassVar[bool]

    @abstractmethod
    def read(self, payload: bytes | memoryview) -> M_co:
        """Parse one message of any ROS 2 sender; every claimed size is checked.

        Args:
            payload: Serialised message.

        Returns:
            Its content; for a type that becomes a time series its layout.

        Raises:
            MessageError: The bytes are not a message of this type.
        """


class AbstractSeriesCodec(AbstractCodec[L], Generic[L]):
    """A message type of which a topic becomes a time series of a log.

    All messages of one layout are decoded at once: `read` returns the layout of a message, that is which bytes are
    constant and where its numbers are.
    """

    @abstractmethod
    def assemble(self, topic: str, segments: Sequence[Segment[L]], warnings: list[str]) -> Series:
        """Make a time series of decoded messages.

        Args:
            topic: Name of the topic, for warnings.
            segments: Decoded messages, at least one.
            warnings: Receives what was left out or repaired.
        """

    @abstractmethod
    def columns(self, series: Any) -> tuple[MessageLayout, list[FloatArray]]:
        """Return the inverse of `assemble`: one layout for all messages, and the numbers of each span, shape (n, size).

        Args:
            series: A time series as `assemble` returns it.
        """

    @abstractmethod
    def serialiser(self) -> Callable[[Any], bytes]:
        """Return a function that serialises a message object with the fields of this type.

        It translates messages whose definition in the file differs from the common one. It may raise any exception if
        a field is missing or of another kind.
        """


@cache
def codecs() -> Mapping[str, AbstractCodec[Any]]:
    """Find all codecs in this package, by message type."""
    found = members("flexros.logs.messages", AbstractCodec, "type")  # type: ignore[type-abstract]
    return MappingProxyType({name: codec() for name, codec in found.items()})


def series_codecs() -> Mapping[str, AbstractSeriesCodec[Any]]:
    """Return the codecs whose topics become time series, by message type."""
    return {name: codec for name, codec in codecs().items() if isinstance(codec, AbstractSeriesCodec)}


def codec_of(type_name: str) -> AbstractCodec[Any]:
    """Return the codec of a message type.

    Raises:
        InputError: There is none.
    """
    if type_name not in codecs():
        raise unknown_name("message type", type_name, codecs(), "flexros/logs/messages")
    return codecs()[type_name]
