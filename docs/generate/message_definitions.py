"""Write flexros/logs/messages/definitions.json: python docs/generate/message_definitions.py."""

from __future__ import annotations

import json

from flexros.config.topics import load_topics
from flexros.logs.messages.schemas import DEFINITIONS, jazzy_schema


def definitions() -> str:
    """Return the definitions of the types of all topics, by type."""
    types = sorted({topic.type for topic in load_topics().values()})
    rows = {name: dict(zip(("text", "type_hash"), jazzy_schema(name)[1:])) for name in types}
    return json.dumps(rows, indent=1) + "\n"


if __name__ == "__main__":
    DEFINITIONS.write_text(definitions(), encoding="utf-8")
