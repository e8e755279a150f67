from __future__ import annotations

from typing import get_args

import pytest

from flexros.errors import InputError
from flexros.feedforward.base import feedforward_method, feedforward_methods
from flexros.feedforward.specification import FeedforwardSpecification


def test_every_method_can_be_specified_and_every_specified_one_exists() -> None:
    allowed = get_args(FeedforwardSpecification.model_fields["method"].annotation)
    assert sorted(allowed) == sorted(feedforward_methods())


def test_unknown_method_offers_the_nearest() -> None:
    with pytest.raises(
        InputError, match=r"unknown feedforward method 'flexible' in feedforward.method: .*flexible_joint"
    ):
        feedforward_method("flexible")


def test_only_the_published_method_leaves_the_hold_alone() -> None:
    left_alone = [
        (name, order)
        for name, method in feedforward_methods().items()
        for order in (1, 2)
        if not method.compensates_hold(FeedforwardSpecification.model_validate({"method": name, "order": order}))
    ]
    assert left_alone == [("dae", 1)]
