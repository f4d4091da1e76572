"""A node of pyros1 that lives through the whole of `interop/soak.py`: `talker` or `listener`.

It checks all messages by their numbers, and does what the lines on its standard input say: `sample`, `stop` (publish no
more), `quit`. It answers each with a line of JSON; faults are among its counts.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import sys
import threading
import time
from collections import Counter
from typing import Any

import pyros1

NUMBER = "std_msgs/Float64"
RATE = 100.0
PLAYED = 200
"""Messages of the bag that is played again and again."""
VISIT = 10_000.0
"""Numbers of a visitor's messages are this times the visitor's number, and from 0."""


class Row:
    """Checks that numbers follow each other.

    Args:
        name: for the report.
        around: the number at which they begin again from 0; None: never.
    """

    def __init__(self, name: str, faults: list[str], around: int | None = None) -> None:
        self.count = 0
        self.gaps = 0
        self.first: float | None = None
        self.last: float | None = None
        self._name = name
        self._faults = faults
        self._around = around

    def __call__(self, message: Any) -> None:
        value = message.data
        if self.last is None:
            self.first = value
        else:
            expected = self.last + 1
            if self._around is not None and expected >= self._around:
                expected = 0.0
            if value != expected:
                self.gaps += 1
                if len(self._faults) < 20:
                    self._faults.append(f"{self._name}: {value:g} after {self.last:g}")
        self.last = value
        self.count += 1

    def told(self) -> dict[str, Any]:
        """Return what was counted."""
        return {"count": self.count, "gaps": self.gaps, "first": self.first, "last": self.last}


class Resident:
    """What both have in common: the memory, and the answers."""

    def __init__(self, name: str) -> None:
        self.faults: list[str] = []
        self.stopped = threading.Event()
        self.node = pyros1.Node(name, argv=[], rosout=True, log_level="warn")
        self.threads: list[threading.Thread] = []

    def begin(self, *jobs: Any) -> None:
        """Start a thread for each job."""
        for job in jobs:
            thread = threading.Thread(target=self._guard, args=(job,), name=job.__name__)
            self.threads.append(thread)
            thread.start()

    def _guard(self, job: Any) -> None:
        try:
            job()
        except pyros1.NodeShutdownError:
            pass
        except Exception as error:  # noqa: BLE001 - told in the report
            self.faults.append(f"{job.__name__}: {error!r}")

    def told(self) -> dict[str, Any]:
        """Return the counts."""
        raise NotImplementedError

    def serve(self) -> None:
        """Answer the lines of the standard input, to its end."""
        print("ready", flush=True)
        for line in sys.stdin:
            word = line.strip()
            if word == "stop":
                self.stopped.set()
                for thread in self.threads:
                    thread.join(60)
                    if thread.is_alive():
                        self.faults.append(f"{thread.name} does not end")
            if word == "quit":
                break
            gc.collect()
            ctypes.CDLL(None).malloc_trim(0)
            answer = {**self.told(), "faults": self.faults, "blocks": sys.getallocatedblocks()}
            os.write(1, f"told {json.dumps(answer)}\n".encode())  # in one piece: the log writes there, too
        self.stopped.set()
        self.node.shutdown()


class Talker(Resident):
    """Publishes, answers calls, sets a parameter, and hears the visitors."""

    def __init__(self) -> None:
        super().__init__("soak_talker")
        node = self.node
        self.numbers = node.advertise("/soak/numbers", NUMBER, queue_size=0)
        self.fast = node.advertise("/soak/fast", NUMBER, queue_size=5)
        self.state = node.advertise("/soak/state", NUMBER, latch=True)
        self.sent = Counter[str]()
        self.calls = 0
        self.visits: dict[float, Row] = {}
        self.visited = 0
        node.subscribe("/soak/visits", NUMBER, self.heard)
        node.advertise_service("/soak/answer", "std_srvs/SetBool", self.answer)
        node.params.set("/soak/beat", 0)
        self.begin(self.publish, self.beat)

    def answer(self, request: Any) -> Any:
        """Answer a call."""
        self.calls += 1
        return bool(request.data), f"call {self.calls}"

    def heard(self, message: Any) -> None:
        """Take a visitor's message."""
        visitor = message.data // VISIT
        row = self.visits.get(visitor)
        if row is None:
            if len(self.visits) >= 5:
                del self.visits[next(iter(self.visits))]
            row = self.visits[visitor] = Row(f"visitor {visitor:g}", self.faults)
            self.visited += 1
            if message.data % VISIT:
                self.faults.append(f"visitor {visitor:g} begins with {message.data:g}")
        row(message)

    def publish(self) -> None:
        """Publish numbers, evenly, and bursts of others."""
        beat = self.node.rate(RATE)
        while not self.stopped.is_set():
            self.numbers.publish(float(self.sent["numbers"]))
            self.sent["numbers"] += 1
            if self.sent["numbers"] % 20 == 0:
                for _ in range(50):
                    self.fast.publish(float(self.sent["fast"]))
                    self.sent["fast"] += 1
            beat.sleep()

    def beat(self) -> None:
        """Set a parameter and a latched topic."""
        number = 0
        while not self.stopped.wait(0.5):
            number += 1
            self.node.params.set("/soak/beat", number)
            self.state.publish(float(number))

    def told(self) -> dict[str, Any]:
        """Return the counts."""
        return {
            "sent": dict(self.sent),
            "dropped": {"fast": self.fast.dropped, "numbers": self.numbers.dropped},
            "waiting": self.numbers.waiting + self.fast.waiting,
            "calls": self.calls,
            "visitors": self.visited,
            "visits": {f"{number:g}": row.told() for number, row in self.visits.items()},
        }


class Listener(Resident):
    """Subscribes, calls, reads the parameter; and nodes come and go in its process."""

    def __init__(self) -> None:
        super().__init__("soak_listener")
        node = self.node
        self.rows = {
            "numbers": Row("numbers", self.faults),
            "played": Row("played", self.faults, around=PLAYED),
        }
        node.subscribe("/soak/numbers", NUMBER, self.rows["numbers"])
        node.subscribe("/soak/played", NUMBER, self.rows["played"])
        self.slow_count = 0
        self.slow_last = -1.0
        self.slow_first: float | None = None
        self.slow_subscriber = node.subscribe("/soak/fast", NUMBER, self.slow, queue_size=3)
        self.calls = self.comers = self.reads = 0
        self.begin(self.call, self.read, self.come_and_go)

    def slow(self, message: Any) -> None:
        """Take a message, slowly."""
        if self.slow_first is None:
            self.slow_first = message.data
        if message.data <= self.slow_last:
            self.faults.append(f"fast: {message.data:g} after {self.slow_last:g}")
        self.slow_last = message.data
        self.slow_count += 1
        time.sleep(0.005)

    def call(self) -> None:
        """Call the service, over one connection and over new ones."""
        kept = self.node.service("/soak/answer", "std_srvs/SetBool", persistent=True)
        fresh = self.node.service("/soak/answer", "std_srvs/SetBool")
        self.node.wait_for_service("/soak/answer", timeout=60)
        while not self.stopped.wait(0.2):
            for client in (kept, fresh):
                if not client(data=True).success:
                    self.faults.append("a wrong answer")
                self.calls += 1
        kept.close()

    def read(self) -> None:
        """Read the parameter, from the copy, and sometimes from the master."""
        last = 0
        while not self.stopped.wait(0.1):
            value = self.node.params.cached("/soak/beat", 0)
            if value < last:
                self.faults.append(f"the parameter went back from {last} to {value}")
            last = value
            self.reads += 1

    def come_and_go(self) -> None:
        """Make nodes in this process, some of them of the same name, and end them."""
        while not self.stopped.wait(0.7):
            self.comers += 1
            with pyros1.Node("soak_comer", argv=[], handle_signals=False) as node:
                row = Row(f"comer {self.comers}", self.faults)
                heard = threading.Event()
                node.subscribe(
                    "/soak/numbers", NUMBER, lambda message, row=row, heard=heard: (row(message), heard.set())
                )  # type: ignore[misc]
                node.advertise(f"/soak/comer{self.comers % 3}", NUMBER, latch=True).publish(1.0)
                node.service("/soak/answer", "std_srvs/SetBool")(data=True)
                if not heard.wait(30):
                    self.faults.append(f"comer {self.comers} heard nothing")
                if self.comers % 4 == 0:
                    with pyros1.Node("soak_comer", argv=[], handle_signals=False):
                        until = time.monotonic() + 30
                        while node.ok() and time.monotonic() < until:
                            time.sleep(0.02)
                        if node.ok():
                            self.faults.append(f"comer {self.comers} outlived its successor")

    def told(self) -> dict[str, Any]:
        """Return the counts."""
        return {
            **{name: row.told() for name, row in self.rows.items()},
            "fast": {
                "count": self.slow_count,
                "first": self.slow_first,
                "last": self.slow_last,
                "dropped": self.slow_subscriber.dropped,
            },
            "calls": self.calls,
            "comers": self.comers,
            "reads": self.reads,
        }


if __name__ == "__main__":
    {"talker": Talker, "listener": Listener}[sys.argv[1]]().serve()
