"""The roles that publish at a steady rate, or hear what comes at one. See roles.py."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable
from typing import Any

from measuring import Cpu, cpu_seconds, figures, now, ready, share
from role_parts import SETTLE, Counter, RoleParts


class SteadyRoles(RoleParts):
    """The roles of steady rates."""

    def rate(self) -> None:
        publisher, message = self._publisher(), self._message()
        self._linked(publisher, 1)
        rate, late = self.library.rate(1000), []
        rate.sleep()
        cpu = Cpu()
        start = last = now()
        while self.library.ok() and last - start < self.seconds:
            self.payload.change(message, 0, now)
            publisher.publish(message)
            rate.sleep()
            last, before = now(), last
            late.append(abs(last - before - 0.001))
        figures(jitter50=share(late, 0.5), jitter99=share(late, 0.99), cpu=cpu.percent())

    def arrivals(self) -> None:
        """How steadily the messages of `rate` arrive, whoever publishes them."""
        times: list[float] = []
        self.library.subscribe("bench", self._class(), lambda _: times.append(now()), self.queue)
        ready()
        self._settle(lambda: times)
        first = len(times)
        time.sleep(self.seconds)
        off = [abs(after - before - 0.001) for before, after in itertools.pairwise(times[first:])]
        figures(jitter50=share(off, 0.5), jitter99=share(off, 0.99))

    def sense(self) -> None:
        """The sensor of a loop. A message is the time at which it was measured."""
        publisher, message = self.library.advertise("sensed", self._class(), self.queue), self._message()
        self._linked(publisher, 1)

        def measure() -> None:
            message.data = now()
            publisher.publish(message)

        figures(cpu=self._steady(1000, measure))

    def control(self) -> None:
        """The controller, between the two."""
        publisher = self.library.advertise("commanded", self._class(), self.queue)
        self._linked(publisher, 1)
        came = threading.Event()

        def heard(message: Any) -> None:
            publisher.publish(message)
            came.set()

        self.library.subscribe("sensed", self._class(), heard, self.queue)
        ready()
        self._settle(came.is_set)
        cpu = Cpu()
        time.sleep(self.seconds)
        figures(cpu=cpu.percent())
        self.library.spin()

    def act(self) -> None:
        """The actuator, and how long ago the sensor measured."""
        times: list[float] = []

        def heard(message: Any) -> None:
            times.append(now() - message.data)

        self.library.subscribe("commanded", self._class(), heard, self.queue)
        ready()
        self._settle(lambda: times)
        first, cpu = len(times), Cpu()
        time.sleep(self.seconds)
        percent, times = cpu.percent(), times[first:]
        figures(p50=share(times, 0.5), p99=share(times, 0.99), cpu=percent, n=len(times))

    def beats(self) -> None:
        publishers = [self.library.advertise(f"beat{i}", self._class(), self.queue) for i in range(self.count)]
        message = self._message()
        ready()
        for publisher in publishers:
            self._linked(publisher, 1)
        turns = itertools.cycle([(publisher,) for publisher in publishers] if self.apart else [tuple(publishers)])

        def beat() -> None:
            for publisher in next(turns):
                publisher.publish(message)

        figures(cpu=self._steady(100 * (self.count if self.apart else 1), beat))

    def hears(self) -> None:
        counter = Counter(self.payload)
        for i in range(self.count):
            self.library.subscribe(f"beat{i}", self._class(), counter.heard, self.queue)
        ready()
        self._settle(lambda: counter.count)
        first, cpu = counter.count, Cpu()
        time.sleep(self.seconds)
        percent = cpu.percent()
        figures(cpu=percent, rate=(counter.count - first) / (now() - cpu.start))

    def tf_hears(self) -> None:
        """A listener, and what a message takes of the processor. x of each transform is the number of its message."""
        buffer, latest = self.library.transforms(), type(self.library.now())()
        ready()
        self._settle(lambda: buffer.can_transform("base_link", "link_19", latest))

        def newest() -> float:
            return float(buffer.lookup_transform("base_link", "link_19", latest).transform.translation.x)

        first, used = newest(), cpu_seconds()
        time.sleep(self.seconds)
        figures(cpu=(cpu_seconds() - used) * 1e6 / (newest() - first))

    def _steady(self, frequency: float, publish: Callable[[], Any]) -> float:
        """Publish at a frequency in Hz; returns what this took, in percent of a processor, once all has settled."""
        rate = self.library.rate(frequency)

        def go(seconds: float) -> None:
            end = now() + seconds
            while self.library.ok() and now() < end:
                publish()
                rate.sleep()

        go(SETTLE)
        cpu = Cpu()
        go(self.seconds)
        percent = cpu.percent()
        go(1)  # the others measure a little later
        return percent
