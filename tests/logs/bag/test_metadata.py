from __future__ import annotations

from io import StringIO
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from flexros.config.topics import load_topics
from flexros.logs.bag.metadata import BagMetadata, BagTopic, as_yaml, offered_qos, write_whole


def make():
    qos = load_topics()["joint_states"].qos
    topics = (BagTopic("/a", "x/msg/X", qos, "RIHS01_1", 3), BagTopic("/b", "x/msg/X", qos, "RIHS01_1", 4))
    return BagMetadata("log_0.mcap", topics, 1_000, 5_000)


def test_version_nine_has_all_keys():
    assert set(make().content()) == {
        "version",
        "storage_identifier",
        "duration",
        "starting_time",
        "message_count",
        "topics_with_message_count",
        "compression_format",
        "compression_mode",
        "relative_file_paths",
        "files",
        "custom_data",
        "ros_distro",
    }


def test_counts_and_times():
    content = make().content()
    assert content["message_count"] == 7
    assert content["duration"] == {"nanoseconds": 4_000}
    assert content["starting_time"] == {"nanoseconds_since_epoch": 1_000}
    assert content["files"][0]["message_count"] == 7


def test_qos_in_words_and_infinite_times():
    offered = offered_qos(load_topics()["joint_states"].qos)
    assert (offered["history"], offered["reliability"], offered["durability"]) == ("keep_last", "reliable", "volatile")
    assert offered["deadline"] == offered["lifespan"] == {"sec": 9223372036, "nsec": 854775807}


def test_yaml_is_read_back_and_has_no_references(tmp_path):
    make().write(tmp_path)
    text = (tmp_path / "metadata.yaml").read_text()
    assert YAML(typ="safe").load(text) == {"rosbag2_bagfile_information": make().content()}
    assert "&" not in text
    assert "version: 9" in text


def test_list_as_yaml():
    assert as_yaml([{"depth": 1}]).strip() == "- depth: 1"


def test_failed_writing_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "metadata.yaml"
    write_whole(path, "old")

    def full(self, content):
        self.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(path, "new")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["metadata.yaml"]


@pytest.mark.parametrize(
    "name", ["/a", "/a b", "a: b", "true", "Null", "1.5", "-", "", "/ä", "x" * 200, "#a", "a#b/c.d"]
)
def test_yaml_is_that_of_ruamel(name):
    qos = [topic.qos for topic in load_topics().values()]
    topics = tuple(BagTopic(f"{name}{k or ''}", "x/msg/X", qos[k], name) for k in range(len(qos)))
    for metadata in (BagMetadata(f"{name}_0.mcap", topics, -5, 10**18), BagMetadata("log_0.mcap", ())):
        content, stream = {"top": metadata.content(), "lists": [1, [2, [name]], {"a": [name, {"b": 1}]}]}, StringIO()
        yaml = YAML(typ="safe", pure=True)
        yaml.default_flow_style = False
        yaml.sort_base_mapping_type_on_output = False
        yaml.representer.ignore_aliases = lambda data: True
        yaml.dump(content, stream)
        assert as_yaml(content) == stream.getvalue()
