"""Topics and quality-of-service profiles as typed, validated objects, read from `msgs_config`."""

from __future__ import annotations

from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from flexros.config.location import data_folder
from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


class QosProfile(BaseModel):
    """Quality of service of one end of a topic.

    Attributes:
        name: Key in `qos.yaml`.
        description: What the profile is for.
        history: Whether the last `depth` samples are kept, or all.
        depth: Number of samples kept.
        reliability: Whether lost samples are sent again.
        durability: Whether late subscribers get earlier samples.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    description: str = Field(min_length=1)
    history: Literal["keep_last", "keep_all"]
    depth: int = Field(ge=1, le=100_000)
    reliability: Literal["reliable", "best_effort"]
    durability: Literal["volatile", "transient_local"]


class FieldUnit(BaseModel):
    """Unit and meaning of one message field; unit "" where it has none."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    unit: str
    meaning: str = Field(min_length=1)


class Topic(BaseModel):
    """One row of `topics.yaml`.

    Attributes:
        name: Topic name; relative unless it begins with a slash.
        description: What the messages carry.
        type: ROS 2 message type, e.g. "sensor_msgs/msg/JointState".
        rate: Messages per second of simulated time [Hz], None when published on demand.
        qos: Profile that the producer offers and the recorder asks for.
        subscription_qos: Profile of the other subscriptions.
        recorded: Whether the recorder takes the topic.
        required: Whether a log without the topic is refused.
        producer: Node that publishes it, "user" for any node of the user.
        consumers: Nodes that subscribe to it.
        fields: Unit and meaning by field.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(pattern=r"^/?[a-z][a-z0-9_]*$")
    description: str = Field(min_length=1)
    type: str = Field(pattern=r"^[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*$")
    rate: float | None = Field(gt=0.0, le=1e6, allow_inf_nan=False)
    qos: QosProfile
    subscription_qos: QosProfile
    recorded: bool
    required: bool
    producer: Literal["plant", "controller", "feedforward", "recorder", "user"]
    consumers: tuple[Literal["plant", "controller", "feedforward", "recorder"], ...]
    fields: dict[str, FieldUnit] = Field(min_length=1)

    @field_validator("consumers", mode="before")
    @classmethod
    def _as_tuple(cls, value: object) -> object:
        return tuple(value) if isinstance(value, list) else value


def _first_problem(path: Path, row: str, error: ValidationError) -> InputError:
    problem = error.errors()[0]
    key = ".".join((row, *(str(part) for part in problem["loc"])))
    given = "" if problem["type"] == "missing" else f", given was {problem['input']!r}"
    return InputError(f"{path}, key {key}: {problem['msg'][0].lower()}{problem['msg'][1:]}{given}; correct the file")


def _rows(path: Path) -> dict[str, dict[str, Any]]:
    content = read_yaml(path)
    for name, row in content.items():
        if not isinstance(name, str) or not isinstance(row, dict):
            raise InputError(f"{path}, key {name}: allowed is a name with a mapping of keys; correct the file")
    return content


def read_qos(path: Path) -> dict[str, QosProfile]:
    """Read quality-of-service profiles.

    Args:
        path: A file like `msgs_config/qos.yaml`.

    Returns:
        Profiles by name.

    Raises:
        InputError: The file cannot be read or a value is not allowed.
    """
    profiles = {}
    for name, row in _rows(path).items():
        try:
            profiles[name] = QosProfile.model_validate({"name": name, **row})
        except ValidationError as error:
            raise _first_problem(path, name, error) from error
    return profiles


def read_topics(path: Path, profiles: Mapping[str, QosProfile]) -> dict[str, Topic]:
    """Read topics.

    Args:
        path: A file like `msgs_config/topics.yaml`.
        profiles: Profiles that the rows may name.

    Returns:
        Topics by name without a leading slash, in the order of the file.

    Raises:
        InputError: The file cannot be read, a value is not allowed or a profile is unknown.
    """
    topics = {}
    for name, row in _rows(path).items():
        names = {"qos": row.get("qos"), "subscription_qos": row.get("subscription_qos", row.get("qos"))}
        for key, profile in names.items():
            if profile not in profiles:
                raise unknown_name("QoS profile", str(profile), profiles, f"{path}, key {name}.{key}")
        resolved = {key: profiles[str(profile)] for key, profile in names.items()}
        try:
            topics[name.lstrip("/")] = Topic.model_validate({"name": name, **row, **resolved})
        except ValidationError as error:
            raise _first_problem(path, name, error) from error
    return topics


@lru_cache(maxsize=1)
def _installed() -> Mapping[str, Topic]:
    folder = data_folder("msgs_config")
    return MappingProxyType(read_topics(folder / "topics.yaml", read_qos(folder / "qos.yaml")))


def load_qos() -> dict[str, QosProfile]:
    """Read the profiles of the installation, by name."""
    return read_qos(data_folder("msgs_config") / "qos.yaml")


def load_topics() -> dict[str, Topic]:
    """Read the topics of the installation, by name without a leading slash ("clock" for /clock)."""
    return dict(_installed())
