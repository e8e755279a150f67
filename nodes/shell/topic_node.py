"""A node's dealings with others: topics, services and timers, made from data and closed with the node."""

from __future__ import annotations

from abc import abstractmethod
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidParameterTypeException
from std_srvs.srv import Trigger

from flexros.errors import FlexrosError, InputError
from flexros.logs.messages.cdr_cursor import MessageError
from flexros_nodes.shell.parameter_node import AbstractParameterNode
from flexros_nodes.shell.topic_interface import message_class, overriding_options, qos_profile, topic

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from rclpy.context import Context
    from rclpy.publisher import Publisher
    from rclpy.subscription import Subscription
    from rclpy.timer import Timer

    from flexros_nodes.protocol.parameters import Value


class Answer(NamedTuple):
    """What a service answers: whether it did what was asked for, and a text."""

    success: bool
    message: str


class AbstractTopicNode(AbstractParameterNode):
    """A node whose topics are data, and whose callbacks may raise a FlexrosError, which ends the node.

    Args:
        name: Name of the node.
        context: ROS context; the default one if None.
        values: Parameter values that override files and defaults.

    Attributes:
        active: Whether the node works; only then messages, services and timers are answered.
        steady_clock: Clock of all timers: neither use_sim_time nor a system clock that is set can stop them.
        unreadable: Messages that were none of their type, which anyone may send: they are left aside.
    """

    def __init__(self, name: str, context: Context | None, values: Mapping[str, Value]) -> None:
        self._polled: set[Subscription] = set()
        super().__init__(name, context, values)
        self.active = False
        self.unreadable = 0
        self.steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timers_while_active: list[Timer] = []
        self._made: list[Callable[[], object]] = []

    @abstractmethod
    def end(self, error: FlexrosError | None = None) -> None:
        """End the node's work, because of an error if there is one."""

    def announce(self, name: str) -> Publisher:
        """Make the publisher of a topic; it takes messages or their bytes."""
        row = topic(name)
        with self._overriding_qos(row.name, "publisher") as where:
            publisher = self.create_publisher(
                message_class(row.type),
                row.name,
                qos_profile(row.qos),
                qos_overriding_options=overriding_options(row.qos, where, publisher=True),
            )
        self._made.append(partial(self.destroy_publisher, publisher))
        return publisher

    def listen(self, name: str, callback: Callable[[bytes], None], *, recorder: bool = False) -> Subscription:
        """Subscribe to a topic.

        Args:
            name: Topic.
            callback: Takes the serialised message; called only while the node is active.
            recorder: Ask for the producer's QoS instead of that of the loop.

        Returns:
            The subscription, for `poll`.
        """
        row = topic(name)
        profile = row.qos if recorder else row.subscription_qos

        def receive(message: bytes) -> None:
            if self.active:
                try:
                    callback(message)
                except MessageError as error:
                    self._leave_aside(name, error)
                except FlexrosError as error:
                    self.end(error)

        with self._overriding_qos(row.name, "subscription") as where:
            subscription = self.create_subscription(
                message_class(row.type),
                row.name,
                receive,
                qos_profile(profile),
                qos_overriding_options=overriding_options(profile, where, publisher=False),
                raw=True,
            )
        self._made.append(partial(self._forget_subscription, subscription))
        return subscription

    def _forget_subscription(self, subscription: Subscription) -> None:
        self._polled.discard(subscription)
        self.destroy_subscription(subscription)

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Give the subscriptions that an executor answers: all but those that are polled."""
        return (one for one in super().subscriptions if one not in self._polled)

    def poll(self, subscription: Subscription, *, polled: bool = True) -> None:
        """Let no executor answer a subscription but `take` alone, or give it back to the executor."""
        (self._polled.add if polled else self._polled.discard)(subscription)
        if self.executor is not None:
            self.executor.wake()

    def take(self, subscription: Subscription) -> bool:
        """Hand the oldest message of a polled subscription to its callback; tells whether there was one."""
        handle = subscription.handle
        with handle:
            taken = handle.take_message(subscription.msg_type, subscription.raw)
        if taken is None:
            return False
        subscription.callback(taken[0])
        return True

    def _leave_aside(self, name: str, error: MessageError) -> None:
        self.unreadable += 1
        if self.unreadable == 1:
            self.get_logger().warning(f"a message on {name} is left aside: {error}; further ones are only counted")

    @contextmanager
    def _overriding_qos(self, name: str, entity: str) -> Iterator[str]:
        """Name the parameters for errors, and turn what rclpy raises about them into an error of the input."""
        where = f"parameter qos_overrides.{self.resolve_topic_name(name)}.{entity} of node {self.get_name()}"
        try:
            yield where
        except (InvalidParameterTypeException, RuntimeError) as error:
            if "qos" not in str(error).lower():
                raise
            raise InputError(f"{where}: {error}; correct it, or leave it out") from error

    def offer(self, name: str, answer: Callable[[], Answer]) -> None:
        """Offer a service of type std_srvs/srv/Trigger below the node's name; it refuses unless the node is active."""

        def respond(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            given = Answer(False, f"node {self.get_name()} is not active; activate it first")
            if self.active:
                try:
                    given = answer()
                except FlexrosError as error:
                    self.end(error)
                    given = Answer(False, str(error))
            response.success, response.message = given
            return response

        self._made.append(partial(self.destroy_service, self.create_service(Trigger, f"~/{name}", respond)))

    def every(self, period: float, callback: Callable[[], None]) -> None:
        """Call back at a period of the wall clock [s] until the node is deactivated."""

        def fire() -> None:
            if self.active:
                try:
                    callback()
                except FlexrosError as error:
                    self.end(error)

        self._timers_while_active.append(self.create_timer(period, fire, clock=self.steady_clock))

    def _cancel_timers(self) -> None:
        for timer in self._timers_while_active:
            timer.cancel()
            self.destroy_timer(timer)
        self._timers_while_active.clear()

    def _close_all(self) -> None:
        """Give back publishers, subscriptions and services."""
        for destroy in self._made:
            destroy()
        self._made.clear()
