"""Topics, services and timers of a node, created from data and closed with the node."""

from __future__ import annotations

from abc import abstractmethod
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from std_srvs.srv import Trigger

from flexros.errors import FlexrosError, InputError
from flexros.logs.cdr_cursor import MessageError
from flexros_nodes.protocol.process.interruption import uninterruptible
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
    """Answer of a service: success and a text."""

    success: bool
    message: str


class AbstractTopicNode(AbstractParameterNode):
    """Node whose topics are data and whose callbacks may raise a FlexrosError, which ends the node.

    Args:
        name: Name of the node.
        context: ROS context; the default one if None.
        values: Parameter values that override files and defaults.

    Attributes:
        active: Whether the node is active; only then messages, services and timers are processed.
        steady_clock: Clock of all timers, independent of use_sim_time and of steps of the system clock.
        unreadable: Skipped messages that cannot be decoded; any node may send such.
    """

    # rclpy cannot destroy a node that holds what an interruption has left half made.
    create_publisher = uninterruptible()(Node.create_publisher)
    create_subscription = uninterruptible()(Node.create_subscription)
    create_service = uninterruptible()(Node.create_service)
    create_timer = uninterruptible()(Node.create_timer)

    def __init__(self, name: str, context: Context | None, values: Mapping[str, Value]) -> None:
        self._polled: set[Subscription] = set()
        super().__init__(name, context, values)
        self.active = False
        self.unreadable = 0
        self.steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timers_while_active: list[Timer] = []
        self._resources: list[Callable[[], object]] = []

    @abstractmethod
    def end(self, error: FlexrosError | None = None) -> None:
        """End the node, because of an error if there is one."""

    def announce(self, name: str) -> Publisher:
        """Create the publisher of a topic; it accepts messages or their bytes."""
        row = topic(name)
        with self._overriding_qos(row.name, "publisher") as origin:
            publisher = self.create_publisher(
                message_class(row.type),
                row.name,
                qos_profile(row.qos),
                qos_overriding_options=overriding_options(row.qos, origin, publisher=True),
            )
        self.on_close(partial(self.destroy_publisher, publisher))
        return publisher

    def listen(self, name: str, callback: Callable[[bytes], None], *, recorder: bool = False) -> Subscription:
        """Subscribe to a topic.

        Args:
            name: Topic.
            callback: Called with the serialised message while the node is active.
            recorder: Request the QoS of the producer instead of that of the loop.

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
                    self._skip_message(name, error)
                except FlexrosError as error:
                    self.end(error)

        with self._overriding_qos(row.name, "subscription") as origin:
            subscription = self.create_subscription(
                message_class(row.type),
                row.name,
                receive,
                qos_profile(profile),
                qos_overriding_options=overriding_options(profile, origin, publisher=False),
                raw=True,
            )
        self.on_close(partial(self._forget_subscription, subscription))
        return subscription

    def _forget_subscription(self, subscription: Subscription) -> None:
        self._polled.discard(subscription)
        self.destroy_subscription(subscription)

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Return the subscriptions served by the executor: all but the polled ones."""
        return (subscription for subscription in super().subscriptions if subscription not in self._polled)

    def poll(self, subscription: Subscription, *, polled: bool = True) -> None:
        """Exclude a subscription from the executor, to be read by `take` only, or return it to the executor."""
        (self._polled.add if polled else self._polled.discard)(subscription)
        if self.executor is not None:
            self.executor.wake()

    def take(self, subscription: Subscription) -> bool:
        """Pass the oldest message of a polled subscription to its callback; return whether there was one."""
        handle = subscription.handle
        with handle:
            taken = handle.take_message(subscription.msg_type, subscription.raw)
        if taken is None:
            return False
        subscription.callback(taken[0])
        return True

    def _skip_message(self, name: str, error: MessageError) -> None:
        self.unreadable += 1
        if self.unreadable == 1:
            self.get_logger().warning(f"a message on {name} is skipped: {error}; further ones are only counted")

    @contextmanager
    def _overriding_qos(self, name: str, entity: str) -> Iterator[str]:
        """Yield the name of the parameters for error messages, and convert what rclpy raises into an InputError."""
        origin = f"parameter qos_overrides.{self.resolve_topic_name(name)}.{entity} of node {self.get_name()}"
        try:
            yield origin
        except (InvalidParameterTypeException, RuntimeError) as error:
            if "qos" not in str(error).lower():
                raise
            raise InputError(f"{origin}: {error}; correct or omit it") from error

    def on_close(self, destroy: Callable[[], object]) -> None:
        """Register a callback that releases a resource when the node is cleaned up."""
        self._resources.append(destroy)

    def offer(self, name: str, answer: Callable[[], Answer]) -> None:
        """Offer a service std_srvs/srv/Trigger in the namespace of the node; refused unless the node is active."""

        def respond(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            result = Answer(False, f"node {self.get_name()} is not active; activate it first")
            if self.active:
                try:
                    result = answer()
                except FlexrosError as error:
                    self.end(error)
                    result = Answer(False, str(error))
            response.success, response.message = result
            return response

        self.on_close(partial(self.destroy_service, self.create_service(Trigger, f"~/{name}", respond)))

    def every(self, period: float, callback: Callable[[], None]) -> None:
        """Call back at a wall-clock period [s] until the node is deactivated."""

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
        """Release publishers, subscriptions, services and registered resources."""
        for destroy in self._resources:
            destroy()
        self._resources.clear()
