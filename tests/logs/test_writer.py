from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from flexros.config.topics import load_topics
from flexros.errors import InputError, RunError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.reader import read_log
from flexros.logs.stamps import stamp_ns
from flexros.logs.writer import MAX_CHUNK_DURATION, LogWriter

pytestmark = pytest.mark.slow

TOPICS = load_topics()
ROOT = Path(__file__).parents[2]


def states(n, n_joints=2):
    names = [f"motor_{i + 1}" for i in range(n_joints)]
    template = JointStateTemplate(names, position=True)
    return [(stamp_ns(k, 5e-4), template.fill(stamp_ns(k, 5e-4), [k + 0.5] * n_joints)) for k in range(n)]


def write_states(writer, n):
    for stamp, payload in states(n):
        writer.write(1, stamp, stamp, payload)


def chunks(folder):
    with (folder / f"{folder.name}_0.mcap").open("rb") as stream:
        return make_reader(stream, validate_crcs=True).get_summary().chunk_indexes


def test_messages_are_read_by_the_reference_reader(tmp_path):
    with LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {}) as writer:
        write_states(writer, 3000)
    with (tmp_path / "log" / "log_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        messages = [(m.log_time, m.data, m.sequence) for _, _, m in reader.iter_messages()]
    assert [(t, d) for t, d, _ in messages] == states(3000)
    assert [s for *_, s in messages] == list(range(3000))
    assert summary.statistics.message_count == 3000
    assert summary.statistics.channel_message_counts == {1: 3000}
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (10**9, stamp_ns(2999, 5e-4))


def test_no_chunk_is_longer_than_half_a_second(tmp_path):
    with LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {}) as writer:
        write_states(writer, 3000)
    spans = [c.message_end_time - c.message_start_time for c in chunks(tmp_path / "log")]
    assert len(spans) >= 3
    assert max(spans) <= MAX_CHUNK_DURATION


def test_chunks_are_bounded_in_size(tmp_path):
    payload = bytes(100_000)
    with LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {}) as writer:
        for k in range(50):
            writer.write(1, 10**9 + k, 10**9 + k, payload)
    sizes = [c.uncompressed_size for c in chunks(tmp_path / "log")]
    assert max(sizes) < 1_100_000
    assert len(sizes) == 5


def test_messages_slightly_out_of_order_share_chunks(tmp_path):
    with LogWriter(tmp_path / "log", [TOPICS["joint_states"], TOPICS["joint_commands"]], {}) as writer:
        for stamp, payload in states(1800):
            writer.write(1, stamp, stamp, payload)
            writer.write(2, stamp - 1_000_000, stamp, payload)
    found = chunks(tmp_path / "log")
    assert len(found) <= 3
    assert all(c.message_end_time - c.message_start_time <= MAX_CHUNK_DURATION for c in found)


def test_flush_makes_messages_safe(tmp_path):
    with LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {}) as writer:
        write_states(writer, 10)
        writer.flush()
        assert writer.counts == {"/joint_states": 10}
        log = read_log(tmp_path / "log")
    assert len(log.joint_states.stamp) == 10
    assert any("has no end record" in warning for warning in log.warnings)


def test_namespace_is_put_before_relative_names(tmp_path):
    topics = [TOPICS["joint_states"], TOPICS["diagnostics"]]
    with LogWriter(tmp_path / "log", topics, {}, namespace="/robot1") as writer:
        assert list(writer.counts) == ["/robot1/joint_states", "/diagnostics"]
        assert writer.topic_id("joint_states") == 1
        assert writer.topic_id("/diagnostics") == 2
        with pytest.raises(InputError, match="unknown topic 'joint_state'"):
            writer.topic_id("joint_state")


def test_metadata_is_written_at_the_start_and_updated_at_the_end(tmp_path):
    folder = tmp_path / "log"
    with LogWriter(folder, [TOPICS["joint_states"]], {}) as writer:
        assert "/joint_states" in (folder / "metadata.yaml").read_text()
        assert "message_count: 0" in (folder / "metadata.yaml").read_text()
        write_states(writer, 20)
    assert "message_count: 20" in (folder / "metadata.yaml").read_text()
    assert sorted(p.name for p in folder.iterdir()) == ["log_0.mcap", "metadata.yaml", "provenance.json"]


def test_provenance_from_start_and_end(tmp_path):
    writer = LogWriter(tmp_path / "log", [], {"seed": 3})
    path = tmp_path / "log" / "provenance.json"
    assert json.loads(path.read_text()) == {"seed": 3}
    writer.close({"seed": 3, "resends": 1})
    assert json.loads(path.read_text()) == {"resends": 1, "seed": 3}


@pytest.mark.parametrize("value", [float("nan"), object()])
def test_provenance_that_is_no_json_is_refused(tmp_path, value):
    with pytest.raises(InputError, match="the provenance cannot be written as JSON"):
        LogWriter(tmp_path / "log", [], {"x": value})
    assert not (tmp_path / "log").exists()


def test_closing_twice_does_nothing(tmp_path):
    writer = LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {})
    write_states(writer, 3)
    writer.close()
    content = (tmp_path / "log" / "log_0.mcap").read_bytes()
    writer.close()
    assert (tmp_path / "log" / "log_0.mcap").read_bytes() == content


@pytest.mark.parametrize(
    "use",
    [
        lambda writer: writer.write(1, 10**9, 10**9, b"x"),
        lambda writer: writer.write_many(np.array([1]), np.array([10**9]), [b"x"]),
        lambda writer: writer.flush(),
    ],
    ids=["write", "write_many", "flush"],
)
def test_a_closed_log_says_so(tmp_path, use):
    writer = LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {})
    write_states(writer, 3)
    writer.close()
    with pytest.raises(RunError, match=r"the log .*log is closed"):
        use(writer)
    assert len(read_log(tmp_path / "log").joint_states.stamp) == 3


@pytest.mark.parametrize(("number", "time"), [(0, 10**9), (2, 10**9), (1, -5), (1, 2**63)])
def test_impossible_number_or_time_is_refused(tmp_path, number, time):
    writer = LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {})

    def write():
        writer.write(number, time, 0, b"x")
        writer.flush()

    with pytest.raises(ValueError, match=r"topic number outside 1 to 1|log time is"):
        write()
    writer.close()


def test_chunk_duration_is_limited(tmp_path):
    with pytest.raises(InputError, match="chunk_duration is 600000000 ns, allowed is 1 to 500000000 ns"):
        LogWriter(tmp_path / "log", [], {}, chunk_duration=600_000_000)


def test_existing_folder_is_refused(tmp_path):
    (tmp_path / "log").mkdir()
    with pytest.raises(InputError, match=r"log exists already; name another one, or remove it"):
        LogWriter(tmp_path / "log", [], {})


def test_folder_that_cannot_be_created_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"cannot create the log folder .*: Not a directory; name a folder"):
        LogWriter(tmp_path / "file" / "log", [], {})


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_folder_is_named(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="Permission denied; name a folder that can be written"):
        LogWriter(tmp_path / "log", [], {})


def test_folder_without_space_is_named(tmp_path, monkeypatch):
    def full(self, *args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(InputError, match="cannot create the log folder .*: No space left on device; name a folder"):
        LogWriter(tmp_path / "log", [], {})


def run(code, tmp_path, **kwargs):
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code), str(tmp_path / "log")],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **kwargs,
    )


PREPARE = """
    import sys
    from pathlib import Path
    import numpy as np
    from flexros.config.topics import load_topics
    from flexros.logs.messages.joint_state import JointStateTemplate
    from flexros.logs.stamps import stamp_ns
    from flexros.logs.writer import LogWriter
    template = JointStateTemplate(["motor_1"], position=True)
    rng = np.random.default_rng(0)
    writer = LogWriter(Path(sys.argv[1]), [load_topics()["joint_states"]], {"seed": 1})
    def write(begin, end):
        for k in range(begin, end):
            writer.write(1, stamp_ns(k, 5e-4), stamp_ns(k, 5e-4), template.fill(stamp_ns(k, 5e-4), rng.normal(size=1)))
"""


def test_killed_recorder_leaves_every_flushed_message(tmp_path):
    code = (
        PREPARE
        + """
    write(0, 2500)
    writer.flush()
    write(2500, 2600)
    print("written", flush=True)
    sys.stdin.read()
"""
    )
    process = run(code, tmp_path, stdin=subprocess.PIPE)
    assert process.stdout.readline() == "written\n", process.stderr.read()
    process.send_signal(signal.SIGKILL)
    process.communicate()
    log = read_log(tmp_path / "log")
    assert log.joint_states.stamp.tolist() == [stamp_ns(k, 5e-4) for k in range(2500)]
    assert log.provenance == {"seed": 1}
    assert any("has no end record" in warning for warning in log.warnings)


def test_full_disk_ends_the_run_with_a_readable_log(tmp_path):
    """A limit on the file size makes the operating system refuse further bytes, like a full disk."""
    code = (
        PREPARE
        + """
    import resource
    from flexros.errors import RunError
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
    try:
        write(0, 200_000)
        writer.close()
    except RunError as error:
        print(error)
    try:
        write(200_000, 200_001)
    except RunError as error:
        print(error)
    writer.close()
"""
    )
    process = run(code, tmp_path)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    first, again = out.splitlines()
    assert "cannot write the log" in first
    assert "File too large" in first
    assert "are readable; make space and run again" in first
    assert again == first
    log = read_log(tmp_path / "log")
    n = len(log.joint_states.stamp)
    assert n > 1000
    assert f"its {n} messages up to t = {(n - 1) * 5e-4:.3f} s of the run are readable" in first
    np.testing.assert_array_equal(log.joint_states.stamp, [stamp_ns(k, 5e-4) for k in range(n)])
    assert log.warnings == (), "the summary fits"
    assert f"message_count: {n}" in (tmp_path / "log" / "metadata.yaml").read_text()


def refuse(*args):
    raise OSError(28, "No space left on device")


def test_failure_while_closing_keeps_every_message(tmp_path, monkeypatch):
    writer = LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {})
    write_states(writer, 100)
    monkeypatch.setattr(writer._file, "finish", refuse)
    with pytest.raises(RunError, match=r"No space left on device; its 100 messages .* readable \(without summary\)"):
        writer.close()
    log = read_log(tmp_path / "log")
    assert len(log.joint_states.stamp) == 100
    assert any("has no end record" in warning for warning in log.warnings)


def test_failure_of_the_metadata_is_reported(tmp_path, monkeypatch):
    writer = LogWriter(tmp_path / "log", [TOPICS["joint_states"]], {})
    write_states(writer, 100)
    monkeypatch.setattr("flexros.logs.bag.metadata.write_whole", refuse)
    with pytest.raises(RunError, match=r"No space left .* \(without up-to-date metadata.yaml\)"):
        writer.close()
    assert (tmp_path / "log" / "log_0.mcap").read_bytes().count(b"\x89MCAP0\r\n") == 2, "one summary"
    assert len(read_log(tmp_path / "log").joint_states.stamp) == 100
