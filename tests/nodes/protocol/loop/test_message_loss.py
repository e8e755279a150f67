"""Messages lost on purpose."""

from __future__ import annotations

from flexros_nodes.protocol.loop.message_loss import MessageLoss


def test_share_of_losses_is_the_fraction() -> None:
    loss = MessageLoss(0.01, seed=3)
    lost = sum(loss.drops() for _ in range(20_000))
    assert lost == loss.dropped
    assert 150 < lost < 250  # 200 expected, 14 one standard deviation


def test_same_seed_loses_the_same_messages() -> None:
    first, second = MessageLoss(0.3, seed=5), MessageLoss(0.3, seed=5)
    assert [first.drops() for _ in range(100)] == [second.drops() for _ in range(100)]


def test_nothing_is_lost_without_a_fraction() -> None:
    loss = MessageLoss(0.0, seed=1)
    assert not any(loss.drops() for _ in range(100))
