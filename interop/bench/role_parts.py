"""What all roles are made of: what they need of a library, their options, publishing, waiting and counting."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

from measuring import figures, now
from payloads import PAYLOADS, Payload

SETTLE = 0.3  # seconds after the first message before counting begins
BURST = 50  # small messages between two looks at the clock
PAUSE = 0.00005  # seconds after each image: without it roscpp's publisher replaces what waits before it can be sent


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
    def transforms(self) -> Any: ...
    def serve(self, name: str, service_class: Any, handler: Callable[[Any], Any]) -> Any: ...
    def client(self, name: str, service_class: Any, persistent: bool) -> Callable[..., Any]: ...


class RoleParts:
    """Options, and what several roles do.

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
        self.apart = options.get("apart") == "1"
        self.persistent = options.get("persistent") == "1"

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

    def _settle(self, begun: Callable[[], Any]) -> None:
        """Wait for the first message, and until all is as it will be."""
        self._await(begun)
        time.sleep(SETTLE)

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
