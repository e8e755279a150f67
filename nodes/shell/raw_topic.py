"""Publishers of serialised messages of any installed type."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from rclpy.exceptions import NoTypeSupportImportedException
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.type_support import check_is_valid_msg_type

from flexros.logs.replay.playlist import queue_depth

if TYPE_CHECKING:
    from flexros.logs.replay.recorded_topic import RecordedTopic


class MissingTypeError(Exception):
    """A message type cannot be used on this machine."""


def installed_class(type_name: str) -> type:
    """Return the Python class of a type named in a log.

    The name is untrusted: only a folder `msg`, `srv` or `action` of a package is imported.

    Args:
        type_name: Type, e.g. "sensor_msgs/msg/JointState".

    Returns:
        The class.

    Raises:
        MissingTypeError: The type is not installed.
    """
    package, kind, name = type_name.split("/")
    spec = find_spec(package)
    folders = [] if spec is None else list(spec.submodule_search_locations or [])
    if not any((Path(folder) / kind / "__init__.py").is_file() for folder in folders):
        raise MissingTypeError(f"the package {package} of its type {type_name} is not installed here")
    try:
        message: type = getattr(import_module(f"{package}.{kind}"), name)
        check_is_valid_msg_type(message)
    except (ImportError, AttributeError, RuntimeError, NoTypeSupportImportedException) as error:
        raise MissingTypeError(f"its type {type_name} cannot be used here ({type(error).__name__}: {error})") from error
    return message


def played_qos(topic: RecordedTopic) -> QoSProfile:
    """Return the profile of a publisher: as reliable and durable as the recorded ones."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=queue_depth(topic),
        reliability=ReliabilityPolicy.BEST_EFFORT if topic.best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE,
    )
