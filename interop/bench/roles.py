"""The roles that the two Python programs of the benchmarks play, and `roscpp_bench.cpp` in the same way.

A program is started as ``PROGRAM ROLE KEY=VALUE ...`` and prints ``ready`` once others may come, if it is one that
waits, and at its end one line ``figures NAME=VALUE ...``. Keys: ``type``, ``queue`` (may be ``None`` in rospy and
pyros1), ``seconds``, ``size`` (bytes of an image's data), ``wait`` (subscribers to wait for), ``count`` (topics).

| role | does | figures |
|---|---|---|
| pub | publishes in a tight loop | published (/s), rss (MB that the process grew) |
| sub | counts callbacks | rate (/s), mb (MB/s) |
| echo, ping | answer / round trips (``low=1``: to the callback); ``count`` topics at 100 Hz beside | p50, p99 (us) |
| rate | publishes at 1 kHz by the library's Rate | jitter50, jitter99 (us), cpu (% of one core) |
| srv, call | service of ``type`` Empty or SetBool / calls; ``persistent=1`` | rate (/s) |
| within | publishes and subscribes in one node | rate (/s), mb |
| many, idle | publish / subscribe to ``count`` topics and do nothing | rss (kB per link), threads, cpu (ms in 5 s) |
| latched, first | publish one latched message / wait for it, from the node's start | first (ms) |
"""

from __future__ import annotations

import os
import resource
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from payloads import PAYLOADS, Payload

now = time.perf_counter
SETTLE = 0.3  # seconds after the first message before counting begins
BURST = 50  # small messages between two looks at the clock
PAUSE = 0.00005  # seconds after each image: without it roscpp's publisher replaces what waits before it can be sent
IDLE = 5.0


class Library(Protocol):
    """What the roles need of a ROS client library."""

    def load(self, type_name: str) -> Any: ...
    def load_service(self, type_name: str) -> Any: ...
    def start(self, name: str) -> None: ...
    def ok(self) -> bool: ...
    def spin(self) -> None: ...
    def now(self) -> Any: ...
    def advertise(self, topic: str, message_class: Any, queue: int | None, latch: bool = False) -> Any: ...
    def subscribe(self, topic: str, message_class: Any, callback: Callable[[Any], Any], queue: int | None) -> Any: ...
    def connections(self, handle: Any) -> int: ...
    def rate(self, frequency: float) -> Any: ...
    def serve(self, name: str, service_class: Any, handler: Callable[[Any], Any]) -> Any: ...
    def client(self, name: str, service_class: Any, persistent: bool) -> Callable[..., Any]: ...


class Roles:
    """All roles.

    Args:
        library: the library that plays.
        options: the KEY=VALUE arguments.
    """

    def __init__(self, library: Library, options: dict[str, str]) -> None:
        self.library = library
        self.payload: Payload = PAYLOADS.get(options.get("type", ""), PAYLOADS["Float64"])
        self.type = options.get("type", "Float64")
        queue = options.get("queue", "1000")
        self.queue = None if queue == "None" else int(queue)
        self.seconds = float(options.get("seconds", "5"))
        self.size = int(options.get("size", "0"))
        self.wait = int(options.get("wait", "1"))
        self.count = int(options.get("count", "0"))
        self.low = options.get("low") == "1"
        self.persistent = options.get("persistent") == "1"

    # topics -----------------------------------------------------------------------------------------------------------

    def pub(self) -> None:
        publisher, message = self._publisher(), self._message()
        ready()
        self._linked(publisher, self.wait)
        before = status("VmRSS")
        published = self._publish(publisher.publish, message, self.seconds)
        figures(published=published, rss=(status("VmRSS") - before) / 1e3)

    def sub(self) -> None:
        counter = Counter(self.payload)
        self.library.subscribe("bench", self._class(), counter.heard, self.queue)
        ready()
        self._await(lambda: counter.count)
        time.sleep(SETTLE)
        counter.measure(self.seconds, self.size)

    def within(self) -> None:
        """Messages within one process. An image has data of its own each time, as those of a camera's driver have."""
        counter = Counter(self.payload)
        self.library.subscribe("bench", self._class(), counter.heard, self.queue)
        publisher, message = self._publisher(), self._message()
        self._linked(publisher, 1)
        picture = bytearray(self.size)
        publish = publisher.publish

        def publish_copy(message: Any) -> None:
            message.data = bytes(picture)
            publish(message)

        seconds = self.seconds + SETTLE + 1
        arguments = (publish_copy if self.size else publish, message, seconds)
        publishing = threading.Thread(target=self._publish, args=arguments)
        publishing.start()
        self._await(lambda: counter.count)
        time.sleep(SETTLE)
        counter.measure(self.seconds, self.size)
        publishing.join()

    def echo(self) -> None:
        publisher = self.library.advertise("pong", self._class(), self.queue)
        for i in range(self.count):
            self.library.subscribe(f"beside{i}", self._class(), self.payload.read, self.queue)
        self.library.subscribe("ping", self._class(), publisher.publish, self.queue)
        ready()
        self.library.spin()

    def ping(self) -> None:
        answered, came = threading.Event(), [0.0]

        def heard(_: Any) -> None:
            came[0] = now()
            answered.set()

        publisher = self.library.advertise("ping", self._class(), self.queue)
        subscriber = self.library.subscribe("pong", self._class(), heard, self.queue)
        beside = [self.library.advertise(f"beside{i}", self._class(), self.queue) for i in range(self.count)]
        for handle in (publisher, subscriber, *beside):
            self._linked(handle, 1)
        end = now() + self.seconds
        other = threading.Thread(target=self._publish_beside, args=(beside, end))
        other.start()
        times, message = [], self._message()
        while self.library.ok() and now() < end:
            answered.clear()
            sent = now()
            publisher.publish(message)
            if answered.wait(1):
                times.append((came[0] if self.low else now()) - sent)
            time.sleep(0.0005)
        other.join()
        figures(p50=share(times, 0.5), p99=share(times, 0.99), n=len(times))

    def _publish_beside(self, publishers: list[Any], end: float) -> None:
        """All the further topics at 100 Hz from one thread."""
        message, rate = self._message(), self.library.rate(100)
        while publishers and self.library.ok() and now() < end:
            for publisher in publishers:
                publisher.publish(message)
            rate.sleep()

    def rate(self) -> None:
        publisher, message = self._publisher(), self._message()
        self._linked(publisher, 1)
        rate, late = self.library.rate(1000), []
        rate.sleep()
        start = last = now()
        used = cpu_seconds()
        while self.library.ok() and last - start < self.seconds:
            self.payload.change(message, 0, now)
            publisher.publish(message)
            rate.sleep()
            last, before = now(), last
            late.append(abs(last - before - 0.001))
        cpu = (cpu_seconds() - used) / (now() - start) * 100
        figures(jitter50=share(late, 0.5), jitter99=share(late, 0.99), cpu=cpu)

    # services ---------------------------------------------------------------------------------------------------------

    def srv(self) -> None:
        service = self._service()
        answer = service._response_class
        values = {"success": True, "message": "done"} if self.type == "SetBool" else {}
        self.library.serve("bench_srv", service, lambda _: answer(**values))
        ready()
        self.library.spin()

    def call(self) -> None:
        client = self.library.client("bench_srv", self._service(), self.persistent)
        arguments = (True,) if self.type == "SetBool" else ()
        count, start = 0, now()
        while self.library.ok() and now() - start < self.seconds:
            client(*arguments)
            count += 1
        figures(rate=count / (now() - start))

    def _service(self) -> Any:
        return self.library.load_service(f"std_srvs/{self.type}")

    # many links, and the first message --------------------------------------------------------------------------------

    def many(self) -> None:
        handles = [self.library.advertise(f"idle{i}", self._class(), 10) for i in range(self.count)]
        ready()
        self.library.spin()
        del handles

    def idle(self) -> None:
        first = self.library.subscribe("idle0", self._class(), self.payload.read, 10)
        self._linked(first, 1)
        before = status("VmRSS")
        handles = [
            self.library.subscribe(f"idle{i}", self._class(), self.payload.read, 10) for i in range(1, self.count)
        ]
        for handle in handles:
            self._linked(handle, 1)
        time.sleep(1)  # what links leave to do has been done
        grown, used = status("VmRSS") - before, cpu_seconds()
        time.sleep(IDLE)
        cpu = (cpu_seconds() - used) * 1e3
        figures(rss=grown / len(handles), threads=status("Threads"), cpu=cpu)

    def latched(self) -> None:
        publisher = self.library.advertise("bench_latched", self._class(), 1, latch=True)
        publisher.publish(self._message())
        ready()
        self.library.spin()

    def first(self) -> None:
        """Starts the node itself: that is what is measured."""
        message_class, heard = self._class(), threading.Event()
        start = now()
        self.library.start("first")
        self.library.subscribe("bench_latched", message_class, lambda _: heard.set(), 1)
        if not heard.wait(20):
            sys.exit("the latched message did not come")
        figures(first=(now() - start) * 1e3, whole=since_start() * 1e3)

    # ------------------------------------------------------------------------------------------------------------------

    def _class(self) -> Any:
        return self.library.load(self.payload.type_name)

    def _message(self) -> Any:
        message = self._class()()
        self.payload.fill(message, self.library.load, self.size)
        return message

    def _publisher(self) -> Any:
        return self.library.advertise("bench", self._class(), self.queue)

    def _publish(self, publish: Callable[[Any], Any], message: Any, seconds: float) -> float:
        """Publish for so long, as fast as it goes; returns messages per second."""
        change, clock, burst = self.payload.change, self.library.now, 1 if self.size else BURST
        count, start = 0, now()
        while self.library.ok() and now() - start < seconds:
            for _ in range(burst):
                change(message, count, clock)
                publish(message)
                count += 1
            if self.size:
                time.sleep(PAUSE)
        return count / (now() - start)

    def _linked(self, handle: Any, count: int) -> None:
        self._await(lambda: self.library.connections(handle) >= count)

    def _await(self, reached: Callable[[], Any]) -> None:
        while self.library.ok() and not reached():
            time.sleep(0.01)


class Counter:
    """A subscriber's callback that counts."""

    def __init__(self, payload: Payload) -> None:
        self.count = 0
        self.last: Any = None
        self._read = payload.read

    def heard(self, message: Any) -> None:
        self.count += 1
        self.last = self._read(message)

    def measure(self, seconds: float, size: int) -> None:
        """Print how many messages come, and the MB if they are so large that *size* says it."""
        start, first = now(), self.count
        time.sleep(seconds)
        rate = (self.count - first) / (now() - start)
        assert not size or self.last == size, f"{self.last} bytes instead of {size}"
        figures(rate=rate, mb=rate * size / 1e6)


def share(seconds: list[float], part: float) -> float:
    """The value in microseconds that this part of the times does not exceed."""
    return sorted(seconds)[int(len(seconds) * part)] * 1e6 if seconds else float("nan")


def cpu_seconds() -> float:
    """What this process has used of the processor so far, user and system."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def since_start() -> float:
    """Seconds since this process began, to 10 ms."""
    begun = int(Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[19])
    return time.clock_gettime(time.CLOCK_BOOTTIME) - begun / os.sysconf("SC_CLK_TCK")


def status(key: str) -> int:
    """A number of /proc/self/status; sizes are in kB."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1])
    raise KeyError(key)


def ready() -> None:
    print("ready", flush=True)


def figures(**values: float) -> None:
    print("figures " + " ".join(f"{name}={value:.2f}" for name, value in values.items()), flush=True)


def play(library: Library) -> None:
    """Do what the command line says."""
    role, *rest = sys.argv[1:]
    options = dict(word.split("=", 1) for word in rest if ":=" not in word)
    if role.startswith("_") or not hasattr(Roles, role):
        sys.exit(f"unknown role {role}")
    if role != "first":
        library.start(f"bench_{role}")
    getattr(Roles(library, options), role)()
