"""A record has to be long enough."""

from __future__ import annotations


def test_short_record_is_refused(found, healthy) -> None:
    (finding,) = found("emps", healthy("emps").part(0, 1500))
    assert finding.hopeless
    assert "too short: it has 1.5 s with 1500 measured samples, at least 2 s and 200 samples" in finding.text


def test_record_of_some_seconds_is_reported(found, healthy) -> None:
    texts = [finding.text for finding in found("emps", healthy("emps").part(6000, 12000))]
    assert any("the log lasts 6 s; below 10 s" in text for text in texts)


def test_ten_seconds_are_counted_with_the_last_sample_and_a_tolerance(found, healthy) -> None:
    record = healthy("emps")
    assert record.sample_time == 1e-3
    for n_samples, short in ((10_000, False), (9960, False), (9940, True)):
        texts = [finding.text for finding in found("emps", record.part(0, n_samples))]
        assert any("below 10 s" in text for text in texts) == short
