"""Topics and quality-of-service profiles as typed, validated objects, read from `msgs_config`."""

from __future__ import annotations

from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from flexros.config.location import data_folder
from flexros.config.settings import Settings, validate
from flexros.config.yaml_file import read_rows
from flexros.errors import unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


class QosProfile(Settings):
    """Quality of service of one end of a topic.

    Attributes:
        name: Key in `qos.yaml`.
        description: Purpose of the profile.
        history: Whether the last `depth` samples are kept, or all.
        depth: Number of samples kept.
        reliability: Whether lost samples are sent again.
        durability: Whether late subscribers get earlier samples.
        least_depth: Smallest depth that a user may set.
        lossless: Whether overrides must stay reliable.
    """

    name: str
    description: str = Field(min_length=1)
    history: Literal["keep_last", "keep_all"]
    depth: int = Field(ge=1, le=100_000)
    reliability: Literal["reliable", "best_effort"]
    durability: Literal["volatile", "transient_local"]
    least_depth: int = Field(default=1, ge=1, le=100_000)
    lossless: bool = False


class FieldUnit(Settings):
    """Unit and meaning of one message field; unit "" for none."""

    unit: str
    meaning: str = Field(min_length=1)


class Topic(Settings):
    """One row of `topics.yaml`.

    Attributes:
        name: Topic name; relative unless it begins with a slash.
        description: Content of the messages.
        type: ROS 2 message type, e.g. "sensor_msgs/msg/JointState".
        rate: Messages per second of simulated time [Hz], None when published on demand.
        qos: Profile offered by the producer and requested by the recorder.
        subscription_qos: Profile of all other subscriptions.
        recorded: Whether the recorder records the topic.
        required: Whether a log without the topic is refused.
        producer: Node that publishes it, "user" for any node of the user.
        consumers: Nodes that subscribe to it.
        fields: Unit and meaning by field.
        needs_sensor: Whether it is published only where the robot file states its sensors.
    """

    name: str = Field(pattern=r"^/?[a-z][a-z0-9_]*$")
    description: str = Field(min_length=1)
    type: str = Field(pattern=r"^[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*$")
    rate: float | None = Field(gt=0.0, le=1e6)
    qos: QosProfile
    subscription_qos: QosProfile
    recorded: bool
    required: bool
    producer: Literal["plant", "controller", "feedforward", "identification", "recorder", "user"]
    consumers: tuple[Literal["plant", "controller", "feedforward", "identification", "recorder", "gap_monitor"], ...]
    fields: dict[str, FieldUnit] = Field(min_length=1)
    needs_sensor: bool = False


def read_qos(path: Path) -> dict[str, QosProfile]:
    """Read quality-of-service profiles by name from a file like `msgs_config/qos.yaml`.

    Raises:
        InputError: The file cannot be read or a value is invalid.
    """
    return {
        name: validate(QosProfile, {"name": name, **row}, f"{path}, profile {name}")
        for name, row in read_rows(path).items()
    }


def read_topics(path: Path, profiles: Mapping[str, QosProfile]) -> dict[str, Topic]:
    """Read topics by name without a leading slash, in the order of the file.

    Args:
        path: A file like `msgs_config/topics.yaml`.
        profiles: Profiles by name.

    Raises:
        InputError: The file cannot be read, a value is invalid or a profile is unknown.
    """
    topics = {}
    for name, row in read_rows(path).items():
        names = {"qos": row.get("qos"), "subscription_qos": row.get("subscription_qos", row.get("qos"))}
        for key, profile in names.items():
            if str(profile) not in profiles:
                raise unknown_name("QoS profile", str(profile), profiles, f"{path}, topic {name}, key {key}")
        resolved = {key: profiles[str(profile)] for key, profile in names.items()}
        topics[name.lstrip("/")] = validate(Topic, {"name": name, **row, **resolved}, f"{path}, topic {name}")
    return topics


@lru_cache(maxsize=1)
def _installed() -> Mapping[str, Topic]:
    folder = data_folder("msgs_config")
    return MappingProxyType(read_topics(folder / "topics.yaml", read_qos(folder / "qos.yaml")))


def load_topics() -> dict[str, Topic]:
    """Return the topics of the installation, by name without a leading slash ("clock" for /clock)."""
    return dict(_installed())
