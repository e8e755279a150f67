"""Spinning until something ends it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.task import Future

from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.shell.spinning import make_executor, spin


class LockingFuture(Future):
    """Is interrupted once while it holds a lock that is not reentrant, as rclpy's own may be."""

    def __init__(self) -> None:
        super().__init__()
        self.lock = threading.Lock()
        self.interrupted = False

    def done(self) -> bool:
        with self.lock:
            if not self.interrupted:
                self.interrupted = True
                signal.raise_signal(signal.SIGTERM)
        return super().done()

    def set_result(self, result: object) -> None:
        assert self.lock.acquire(timeout=1.0), "the handler of the signal waits for what it has interrupted"
        self.lock.release()
        super().set_result(result)


@pytest.fixture
def context(ros_domain: int) -> Iterator[Context]:
    context = Context()
    rclpy.init(context=context, args=[], domain_id=ros_domain)
    yield context
    rclpy.try_shutdown(context=context)


@pytest.mark.parametrize("make", [make_executor, lambda context: SingleThreadedExecutor(context=context)])
def test_signal_in_the_midst_of_a_lock_ends_the_spinning(context: Context, make: Callable[[Context], Executor]) -> None:
    node = FeedforwardNode(context=context)
    executor = make(context)
    executor.add_node(node)
    with interruption() as interrupted:
        spin(executor, LockingFuture(), interrupted, node)
        assert interrupted()
    executor.shutdown()
    node.destroy_node()


def test_executor_that_is_never_idle_sees_a_signal(context: Context) -> None:
    node = FeedforwardNode(context=context)
    executor = make_executor(context)
    executor.add_node(node)
    calls = [0]

    def work() -> None:
        calls[0] += 1
        if calls[0] == 50:
            signal.raise_signal(signal.SIGTERM)

    timer = node.create_timer(1e-5, work, clock=node.steady_clock)
    with interruption() as interrupted:
        spin(executor, Future(), interrupted, node)
        assert interrupted()
    timer.cancel()
    executor.shutdown()
    node.destroy_node()


LOOP_WITH_PRIORITY = """
import os, rclpy
from rclpy.task import Future
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.protocol.real_time.precise_timing import late_threads, take_priority
from flexros_nodes.shell.spinning import make_executor, spin

rclpy.init()
node, stop, found = FeedforwardNode(), Future(), []
if take_priority(5):
    executor = make_executor(None)
    executor.add_node(node)
    node.create_timer(0.02, lambda: found.append(len(late_threads())), clock=node.steady_clock)
    node.create_timer(0.3, lambda: stop.set_result(None), clock=node.steady_clock)
    with interruption() as interrupted:
        spin(executor, stop, interrupted, node)
    print(found[0], found[-1])
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="lists the threads of a process as Linux does")
def test_timers_of_the_executor_get_the_priority_of_the_loop(ros_domain: int) -> None:
    environment = {**os.environ, "ROS_DOMAIN_ID": str(ros_domain)}
    done = subprocess.run(
        [sys.executable, "-c", LOOP_WITH_PRIORITY], env=environment, capture_output=True, text=True, check=True
    )
    if not done.stdout:
        pytest.skip("needs the right to real-time priority: ulimit -r")
    first, last = map(int, done.stdout.split())
    assert first > 0
    assert last == 0
