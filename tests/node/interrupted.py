"""A program that is interrupted by signals again and again, whose handler does what handlers may do (test_signals.py).

Usage: interrupted.py SCENARIO [transport [queue_size [latch]]]

It prints what is wrong, with all stacks if it hangs, and ends with exit code 0 if nothing is.
"""

from __future__ import annotations

import contextlib
import faulthandler
import os
import random
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pyros1
from pyros1.ground.errors import NodeShutdownError
from pyros1.msgs.geometry_msgs.msg import Point, PointStamped
from pyros1.msgs.std_srvs.srv import SetBool

DEADLINE = 25.0
PATIENCE = 15.0


class Interruptions:
    """Runs a handler in the main thread at random moments, until it has run often enough.

    Args:
        handler: called with the number of the interruption, from 1.
        count: of interruptions.
    """

    def __init__(self, handler: Callable[[int], object], count: int) -> None:
        self._handler = handler
        self._count = count
        self.number = 0
        signal.signal(signal.SIGALRM, self._handle)
        self._next()

    def _next(self) -> None:
        signal.setitimer(signal.ITIMER_REAL, random.uniform(20e-6, 400e-6))

    def _handle(self, *_: object) -> None:
        self.number += 1
        self._handler(self.number)
        if not self.over:
            self._next()

    @property
    def over(self) -> bool:
        return self.number >= self._count


class Received:
    """What a subscriber gets from the main program (x = 0) and from the handler (x = 1): y counts from 1."""

    def __init__(self) -> None:
        self.by_main: list[int] = []
        self.by_handler: list[int] = []
        self.seqs: list[int] = []
        self.changed = threading.Condition()

    def __call__(self, message: Any) -> None:
        point = message.point if hasattr(message, "point") else message
        with self.changed:
            (self.by_handler if point.x else self.by_main).append(int(point.y))
            if hasattr(message, "header"):
                self.seqs.append(message.header.seq)
            self.changed.notify_all()

    def wait(self, condition: Callable[[], bool]) -> None:
        with self.changed:
            if not self.changed.wait_for(condition, PATIENCE):
                print("lost: got", len(self.by_main), "and", len(self.by_handler), self.by_handler[-3:])
                sys.exit(1)


def message(message_class: Any, by_handler: bool, number: int) -> Any:
    point = Point(float(by_handler), float(number), 0.0)
    return point if message_class is Point else PointStamped(point=point)


def check(condition: object, *what: object) -> None:
    if not condition:
        print("wrong:", *what)
        sys.exit(1)


@contextlib.contextmanager
def two_nodes() -> Iterator[tuple[Any, Any]]:
    options: dict[str, Any] = {"handle_signals": False}
    with pyros1.Node("talker", **options) as talker, pyros1.Node("listener", **options) as listener:
        yield talker, listener


def publishing(queue_size: int | None, latch: bool) -> None:
    """A tight loop that publishes, under a handler that publishes on the same topics and logs."""
    with two_nodes() as (talker, listener):
        for message_class in (Point, PointStamped):
            received, topic = Received(), f"t_{message_class.__name__}"
            subscriber = listener.subscribe(topic, message_class, received, queue_size=None)
            publisher = talker.advertise(topic, message_class, queue_size=queue_size, latch=latch)
            check(publisher.wait_for_subscribers(timeout=PATIENCE), "no subscriber")

            def handle(number: int, publisher: Any = publisher, message_class: Any = message_class) -> None:
                publisher.publish(message(message_class, True, number))
                if number % 16 == 0:
                    talker.log.info("interruption %d", number)

            interruptions = Interruptions(handle, 600)
            count = 0
            while not interruptions.over:
                count += 1
                publisher.publish(message(message_class, False, count))
                if publisher.waiting > 1000:
                    time.sleep(0.01)
            last = message(message_class, False, count + 1)
            publisher.publish(last)
            received.wait(lambda: count + 1 in received.by_main[-1:])  # noqa: B023
            for got in (received.by_main, received.by_handler, received.seqs):
                check(got == sorted(set(got)), "order", message_class, got)
            dropped = publisher.dropped + subscriber.dropped
            total = count + 1 + interruptions.number
            if queue_size in (0, None):
                check(dropped == 0, "dropped", dropped)
                received.wait(lambda: len(received.by_handler) == interruptions.number)  # noqa: B023
                check(received.by_main == list(range(1, count + 2)), "main")
                check(received.by_handler == list(range(1, interruptions.number + 1)), "handler")
                check(received.seqs in ([], list(range(1, total + 1))), "numbers")
            else:
                received.wait(lambda: len(received.by_main) + len(received.by_handler) + dropped == total)  # noqa: B023
            if latch:
                late = Received()
                listener.subscribe(topic, message_class, late)
                late.wait(lambda: bool(late.by_main or late.by_handler))  # noqa: B023
                check(late.by_main == [count + 1], "the latched message", late.by_main, late.by_handler)


def everything(main: str) -> None:
    """A main program that does something, under a handler that publishes, logs, sets a parameter, calls a service."""
    options: dict[str, Any] = {"handle_signals": False}
    callbacks = "spin" if main == "spin" else "inline"
    with pyros1.Node("server", **options) as server, pyros1.Node("main", callbacks=callbacks, **options) as node:
        server.advertise_service("set", SetBool, lambda request: (request.data, "so be it"))
        received = Received()
        server.subscribe("t", Point, received)
        publisher = node.advertise("t", Point, queue_size=10)
        check(publisher.wait_for_subscribers(timeout=PATIENCE), "no subscriber")
        node.subscribe("/own", Point, lambda _: None)
        own = node.advertise("/own", Point)
        once, kept = node.service("set", SetBool), node.service("set", SetBool, persistent=True)
        node.wait_for_service("set", PATIENCE)

        def handle(number: int) -> None:
            publisher.publish(message(Point, True, number))
            own.publish(Point())
            node.log.info("interruption %d", number)
            if number % 5 == 0:
                node.params["~number"] = number
                check(node.params["~number"] == number, "the parameter")
                check(node.params.cached("~number") == number, "the copy")
            if number % 5 == 1:
                check((kept if number % 2 else once)(True).success, "the service")

        interruptions = Interruptions(handle, 150)
        rate, count = node.rate(1000), 0
        works: dict[str, Callable[[], object]] = {
            "rate": rate.sleep,
            "sleep": lambda: node.sleep(0.001),
            "params": lambda: node.params.set("~mine", count),
            "cached": lambda: node.params.cached(f"~c{count % 50}"),
            "log": lambda: node.log.info("%d", count),
            "print": lambda: print(count),
            "service": lambda: check(not once(False).success, "the service"),
            "persistent": lambda: check(not kept(False).success, "the service"),
            "spin": lambda: node.spin_once(0.001),
            "advertise": lambda: node.advertise("other", Point).unregister(),
            "subscribe": lambda: node.subscribe("other", Point, print).unregister(),
            "wait": lambda: publisher.wait_for_subscribers(1, 0.001),
        }
        while not interruptions.over:
            count += 1
            works[main]()
        received.wait(lambda: received.by_handler[-1:] == [interruptions.number])
        check(node.params["~number"] == interruptions.number - interruptions.number % 5, "the last parameter")


def ending(main: str) -> None:
    """A handler that publishes and ends the node, while the main program publishes, waits, logs..."""
    done = 0
    for _ in range(12):
        with pyros1.Node("listener", handle_signals=False) as listener:
            received = Received()
            listener.subscribe("t", Point, received)
            node = pyros1.Node("talker", handle_signals=False)
            hooks: list[int] = []
            node.on_shutdown(lambda: hooks.append(1))  # noqa: B023
            publisher = node.advertise("t", Point, queue_size=10)
            check(publisher.wait_for_subscribers(timeout=PATIENCE), "no subscriber")

            def handle(number: int, node: Any = node, publisher: Any = publisher) -> None:
                publisher.publish(message(Point, True, number))
                node.shutdown()

            interruptions = Interruptions(handle, 1)
            rate = node.rate(10_000)
            with contextlib.suppress(pyros1.ground.errors.NodeError, NodeShutdownError, pyros1.ground.errors.Error):
                while node.ok():
                    if main == "publish":
                        publisher.publish(message(Point, False, 1))
                    elif main == "rate":
                        rate.sleep()
                    elif main == "spin":
                        node.spin()
                    elif main == "params":
                        node.params["~x"] = 1
            node.shutdown()
            check(interruptions.over and hooks == [1], "hooks", hooks)
            received.wait(lambda: received.by_handler == [1])  # noqa: B023
            done += 1
    check(done == 12)


def raising(queue_size: int | None) -> None:
    """KeyboardInterrupt out of a handler, anywhere in publish(): no frame is torn, and the next one arrives."""
    with two_nodes() as (talker, listener):
        received = Received()
        subscriber = listener.subscribe("t", PointStamped, received)
        publisher = talker.advertise("t", PointStamped, queue_size=queue_size)
        check(publisher.wait_for_subscribers(timeout=PATIENCE), "no subscriber")

        def handle(number: int) -> None:
            if working:
                raise KeyboardInterrupt

        def publish_until(interruptions: Interruptions) -> None:
            nonlocal count
            while not interruptions.over:
                count += 1
                publisher.publish(message(PointStamped, False, count))

        working = False
        count = 0
        for number in range(1, 200):
            interruptions = Interruptions(handle, 1)
            try:
                working = True
                publish_until(
                    interruptions
                )  # not here: an exception in a jump to a loop's begin escapes Python 3.13's try
            except KeyboardInterrupt:
                pass
            working = False  # in any case: the handler may have come before it was True
            publisher.publish(message(PointStamped, True, number))
            if number % 20 == 0:
                received.wait(lambda: received.by_handler[-1:] == [number])  # noqa: B023
        received.wait(lambda: received.by_handler[-1:] == [199])
        check(subscriber.num_connections == 1, "the link broke")
        for got in (received.by_main, received.by_handler):
            check(got == sorted(set(got)), "order", got)
        check(received.by_handler == list(range(1, 200)), "lost", len(received.by_handler))


def main() -> None:
    faulthandler.dump_traceback_later(DEADLINE, exit=True)
    sys.setswitchinterval(1e-4)
    scenario, transport, *rest = [*sys.argv[1:], "local"][:4] if len(sys.argv) < 3 else sys.argv[1:]
    sys.argv[1:] = []
    if "PORTABLE" in os.environ:  # as on systems without epoll
        for name in ("epoll", "EPOLLONESHOT"):
            vars(select).pop(name, None)
    if transport == "tcp":
        import pyros1.node.subscribing.connector

        pyros1.node.subscribing.connector.find_local_context = lambda uri: None
    size = None if not rest or rest[0] == "None" else int(rest[0])
    kind, _, what = scenario.partition(":")
    if kind == "publishing":
        publishing(size, rest[1:] == ["latch"])
    elif kind == "raising":
        raising(size)
    else:
        {"everything": everything, "ending": ending}[kind](what)


if __name__ == "__main__":
    main()
