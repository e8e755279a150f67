"""A record has to be long enough."""

from __future__ import annotations


def test_short_record_is_refused(found, healthy) -> None:
    (finding,) = found("emps", healthy("emps").part(0, 1500))
    assert finding.hopeless
    assert finding.text == (
        "the log is too short: it has 1.5 s with 1500 measured samples, needed are 2 s and 400 samples; record longer"
    )


def test_record_of_some_seconds_is_told(found, healthy) -> None:
    texts = [finding.text for finding in found("emps", healthy("emps").part(6000, 12000))]
    assert "the log lasts 6 s; below 10 s weak effects stay hidden" in texts
