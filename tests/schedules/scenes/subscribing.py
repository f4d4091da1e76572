"""A subscription with publishers that come, go and break, and subscribers that come and go.

Callbacks never overlap; each publisher's messages come in order; without a bound all that were sent arrive, and with
one those that did not are counted, and the newest arrives.
"""

from __future__ import annotations

from typing import Any

from pyros1.msgs.std_msgs.msg import UInt64
from pyros1.node.context import Context
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.node.subscribing.subscription import Subscription
from pyros1.node.subscribing.tcp_source import TcpSource

from ..stage import Scenario, Stage
from .parts import (
    DATA,
    PUBLISHING,
    SUBSCRIBING,
    THREAD,
    check_orders,
    end_context,
    make_context,
    make_publication,
    make_subscription,
    write_frames,
)

SOURCES, MESSAGES = 2, 4


class Callback:
    """Keeps the numbers that come; each takes some time.

    Args:
        seconds: the time that one message in three takes.
    """

    def __init__(self, stage: Stage, seconds: float = 0.0) -> None:
        self.numbers: list[int] = []
        self._stage = stage
        self._seconds = seconds
        self._inside = False

    def __call__(self, message: UInt64) -> None:
        assert not self._inside, "two callbacks at the same time"
        self._inside = True
        self._stage.scheduler.point()
        self.numbers.append(message.data)
        if self._seconds and len(self.numbers) % 3 == 0:
            self._stage.time.sleep(self._seconds)
        self._inside = False


def subscribe(
    subscription: Subscription, callback: Any, queue_size: int | None, in_publisher: bool = False
) -> Subscriber[Any]:
    """Add a subscriber."""
    remove: Any = subscription.remove
    subscriber = Subscriber(subscription, UInt64, callback, queue_size, remove, in_publisher=in_publisher)
    subscription.add(subscriber)
    return subscriber


class Subscribing(Scenario):
    """Two publishers that send all and end, over TCP; a subscriber that comes and goes meanwhile."""

    modules = (*DATA, *SUBSCRIBING)
    limits = (
        ("pyros1.node.subscribing.delivery_loop", "MAX_BATCH", 2),
        ("pyros1.node.subscribing.delivery_loop", "MAX_TURN_TIME", 50e-6),
        ("pyros1.node.subscribing.delivery_loop", "MAX_FLOW_GAP", 10.0),
        ("pyros1.node.subscribing.threads", "MIN_WAITING_THREADS", 1),
        ("pyros1.node.subscribing.threads", "IDLE_TIMEOUT", 0.001),
    )
    queue_size: int | None = None
    seconds = 0.0
    spin = False

    def play(self, stage: Stage) -> None:
        """Play it."""
        context = make_context(stage, "/listener", self.spin)
        subscription = make_subscription(context)
        callback, visitor = Callback(stage, self.seconds), Callback(stage)
        subscribe(subscription, callback, self.queue_size)

        def source(thread: int) -> Any:
            near, far = stage.network.pair()

            def publish() -> None:
                header = {"callerid": f"/talker{thread}", "latching": "0"}
                context.loop.call_soon(lambda: subscription.link(TcpSource(near, f"http://{thread}/", header, b"")))
                write_frames(far, thread, MESSAGES)

            return publish

        def visit() -> None:
            subscriber = subscribe(subscription, visitor, self.queue_size)
            subscription.update_limit()
            subscriber.unregister()

        spinning = self.spin_on(stage, context)
        stage.together(visit, *(source(thread) for thread in range(SOURCES)))
        self.settle(stage, subscription, callback)
        self.spin_no_more(context, spinning)
        self.end(context, subscription)
        self.check(subscription, callback.numbers, SOURCES * MESSAGES)
        check_orders(visitor.numbers, gaps=self.queue_size is not None or self.spin)

    def settle(self, stage: Stage, subscription: Subscription, callback: Callback) -> None:
        """Wait until all messages have been delivered or dropped."""
        delivery = subscription.delivery
        stage.until(lambda: len(callback.numbers) + delivery.dropped >= SOURCES * MESSAGES)
        stage.until(lambda: not subscription.links and not delivery.waiting)
        assert self.queue_size is not None or not delivery.dropped, "a message that is being taken counts as dropped"

    def check(self, subscription: Subscription, numbers: list[int], sent: int, tail: bool = True) -> None:
        """Check what came; with ``tail``, the last message of each thread is among it."""
        dropped, gaps = subscription.delivery.dropped, self.queue_size is not None
        assert len(numbers) + dropped == sent, f"{numbers} came, {dropped} of {sent} are counted as dropped"
        assert gaps or not dropped
        check_orders(numbers, MESSAGES, gaps, tail)

    def spin_on(self, stage: Stage, context: Context) -> list[Any]:
        """Begin a thread that spins, in a node that does."""

        def spin() -> None:
            callbacks = context.callback_queue
            while callbacks is not None and not context.stopping.is_set():
                callbacks.wait(0.01)
                callbacks.run_available()

        return stage.spawn(spin)

    def spin_no_more(self, context: Context, spinning: list[Any]) -> None:
        """End the thread that spins; run what is left."""
        context.stopping.set()
        if context.callback_queue is not None:
            context.callback_queue.wake()
        for thread in spinning:
            thread.join()
        while context.callback_queue is not None and context.callback_queue.run_available():
            pass

    def end(self, context: Context, subscription: Subscription) -> None:
        """End all."""
        subscription.close()
        end_context(context)


class Overloaded(Subscribing):
    """The same with a slow callback, and a bound."""

    queue_size = 1
    seconds = 0.01


class Spinning(Subscribing):
    """The same in a node that spins."""

    spin = True


class SpinningOverloaded(Overloaded):
    """The same in a node that spins, with a slow callback and a bound."""

    spin = True


class Within(Subscribing):
    """Publishers and subscriber in one process."""

    modules = (*PUBLISHING, "pyros1.node.publishing.local_link", *SUBSCRIBING)
    publisher_queue: int | None = 0
    in_publisher = False
    limits = (
        *Subscribing.limits,
        ("pyros1.node.strand", "MAX_JOBS_PER_TURN", 2),
        ("pyros1.node.publishing.local_link", "UNBOUNDED_LIMIT", 2),
        ("pyros1.node.subscribing.delivery_loop", "UNBOUNDED_LIMIT", 2),
        ("pyros1.node.subscribing.dispatcher", "UNBOUNDED_LIMIT", 2),
    )

    def play(self, stage: Stage) -> None:
        """Play it."""
        talker, context = make_context(stage, "/talker"), make_context(stage, "/listener", self.spin)
        publication = make_publication(talker, self.publisher_queue)
        subscription = make_subscription(context)
        callback = Callback(stage, self.seconds)
        subscribe(subscription, callback, self.queue_size, self.in_publisher)
        context.loop.run(subscription.link_in_process, talker.uri, publication)
        stage.until(lambda: publication.links)

        def publisher(thread: int) -> Any:
            def publish() -> None:
                for number in range(MESSAGES):
                    publication.publish(UInt64(THREAD * thread + number))

            return publish

        def visit() -> None:
            subscribe(subscription, lambda _: None, self.queue_size).unregister()

        spinning = self.spin_on(stage, context)
        stage.together(visit, *(publisher(thread) for thread in range(SOURCES)))
        publication.close()
        self.settle(stage, subscription, callback)
        self.spin_no_more(context, spinning)
        self.end(context, subscription)
        end_context(talker)
        self.check(subscription, callback.numbers, SOURCES * MESSAGES, tail=self.queue_size is None)


class WithinSpinning(Within):
    """The same in a node that spins, in whose queues there is room for all."""

    spin = True
    limits = tuple(limit for limit in Within.limits if limit[1] != "UNBOUNDED_LIMIT")


class WithinPublisher(Within):
    """The same, with callbacks in the publishers' threads while no visitor is there, who does not want that."""

    in_publisher = True


class WithinPublisherSpinning(WithinSpinning):
    """The same in a node that spins; the visitor's messages wait."""

    in_publisher = True


class WithinDropping(Within):
    """The same with a bound on the subscriber's side, and a slow callback."""

    queue_size = 2
    seconds = 0.01


class WithinWaiting(Within):
    """The same with publishers that wait."""

    publisher_queue = None
    seconds = 0.002
