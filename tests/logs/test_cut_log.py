"""A log truncated at any byte yields every message of every complete chunk, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.reader import read_log
from tests.logs.cut_log import chunk_edges, cuts_of, in_small_chunks, recovery

SAMPLE = Path(__file__).parents[2] / "bags" / "sample_circle_dae" / "sample_circle_dae_0.mcap"


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return the sample log in chunks of 40 kB."""
    in_small_chunks(SAMPLE, tmp_path / "a.mcap", 40_000)
    return tmp_path / "a.mcap"


@pytest.mark.slow
def test_every_message_of_every_complete_chunk_is_read(log: Path) -> None:
    cuts = cuts_of(log.read_bytes(), n_random=50)
    n_chunks = len(chunk_edges(log.read_bytes()))
    found = recovery(log, cuts)
    assert n_chunks > 5
    assert found.n_cuts == len(cuts) > 19 * n_chunks
    assert (found.n_read, found.n_wrong) == (found.n_expected, 0)
    assert found.share == 1.0


def test_log_goes_up_to_its_last_complete_chunk(log: Path) -> None:
    content, whole = log.read_bytes(), read_log(log).joint_states
    end = chunk_edges(content)[2][1]
    log.write_bytes(content[: end - 1])
    before = read_log(log)
    log.write_bytes(content[:end])
    after = read_log(log).joint_states
    assert 0 < len(before.joint_states.stamp) < len(after.stamp) < len(whole.stamp)
    np.testing.assert_array_equal(after.position, whole.position[: len(after.stamp)])
    assert any("is truncated at byte" in warning for warning in before.warnings)


def test_log_that_is_truncated_in_its_first_chunk_is_refused_with_what_to_do(log: Path) -> None:
    content = log.read_bytes()
    start = chunk_edges(content)[0][0]
    log.write_bytes(content[: start + 100])
    with pytest.raises(InputError) as caught:
        read_log(log)
    assert str(caught.value) == (
        f"{log} has no complete message of any topic; {log} is truncated at byte {start} of {start + 100}: everything "
        "before was read; give a whole copy of it, or record the run again"
    )
