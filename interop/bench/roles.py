"""The roles that the two Python programs of the benchmarks play, and `roscpp_bench.cpp` in the same way.

A program is started as ``PROGRAM ROLE KEY=VALUE ...`` and prints ``ready`` once others may come, if it is one that
waits, and at its end one line ``figures NAME=VALUE ...``. Keys: ``type``, ``queue`` (may be ``None`` in rospy and
pyros1), ``seconds``, ``size`` (bytes of an image's data), ``wait`` (subscribers to wait for), ``count`` (topics),
``apart`` (1: each topic has its own time within a hundredth of a second).

| role | does | figures |
|---|---|---|
| pub | publishes in a tight loop | published (/s), rss (MB that the process grew) |
| sub | counts callbacks | rate (/s), mb (MB/s) |
| echo, ping | answer / round trips, to the callback; ``count`` topics at 100 Hz beside | p50, p99 (us) |
| rate | publishes at 1 kHz by the library's Rate | jitter50, jitter99 (us), cpu (% of one core) |
| arrivals | hears what `rate` publishes | jitter50, jitter99 of the intervals (us) |
| sense, control, act | a 1 kHz loop of three processes | cpu (% of one core); act: p50, p99 (us) from end to end |
| beats, hears | publish / subscribe to ``count`` topics at 100 Hz | cpu (% of one core) |
| tf_sends, tf_hears | TFMessages at 1 kHz (C++ only) / a listener with its buffer | cpu (us per message) |
| srv, call | service of ``type`` Empty or SetBool / calls; ``persistent=1`` | rate (/s) |
| within | publishes and subscribes in one node | rate (/s), mb |
| many, idle | publish / subscribe to ``count`` topics and do nothing | rss (kB per link), threads, cpu (ms in 5 s) |
| latched, first | publish one latched message / wait for it, from the node's start | first (ms) |
"""

from __future__ import annotations

import sys
import threading
import time
from typing import Any

from measuring import cpu_seconds, figures, now, ready, share, since_start, status
from role_parts import SETTLE, Counter, Library
from steady_roles import SteadyRoles

IDLE = 5.0


class Roles(SteadyRoles):
    """All roles."""

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
        self._settle(lambda: counter.count)
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
        self._settle(lambda: counter.count)
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
                times.append(came[0] - sent)  # not when this thread is woken, which roscpp's callback needs not
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


def play(library: Library) -> None:
    """Do what the command line says."""
    role, *rest = sys.argv[1:]
    options = dict(word.split("=", 1) for word in rest if ":=" not in word)
    if role.startswith("_") or not hasattr(Roles, role):
        sys.exit(f"unknown role {role}")
    if role != "first":
        library.start(f"bench_{role}")
    getattr(Roles(library, options), role)()
