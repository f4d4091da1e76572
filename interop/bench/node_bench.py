"""The pyros1 side of the benchmarks, on the Node API: ``node_bench.py ROLE KEY=VALUE ...``; see roles.py.

``low=1`` asks subscriptions for low latency, ``arrays=memoryview`` for arrays that refer to the received bytes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from roles import play

from pyros1 import Node
from pyros1.msgs import load_message, load_service


class Pyros1:
    """pyros1 as the roles want a library."""

    load = staticmethod(load_message)
    load_service = staticmethod(load_service)

    def __init__(self) -> None:
        arrays = [word.partition("=")[2] for word in sys.argv[2:] if word.startswith("arrays=")]
        self._options: dict[str, Any] = {"arrays": arrays[0]} if arrays else {}
        if "low=1" in sys.argv[2:]:
            self._options["low_latency"] = True

    def start(self, name: str) -> None:
        self.node = Node(name, anonymous=True, argv=[])
        self.ok, self.spin, self.now, self.rate = self.node.ok, self.node.spin, self.node.now, self.node.rate

    def advertise(self, topic: str, message_class: Any, queue: int | None, latch: bool = False) -> Any:
        return self.node.advertise(topic, message_class, queue_size=queue, latch=latch)

    def subscribe(self, topic: str, message_class: Any, callback: Callable[[Any], Any], queue: int | None) -> Any:
        return self.node.subscribe(topic, message_class, callback, queue_size=queue, **self._options)

    def connections(self, handle: Any) -> int:
        return int(handle.num_connections)

    def transforms(self) -> Any:
        from pyros1.tf import Buffer, TransformListener

        self.listener = TransformListener(self.node, Buffer())
        return self.listener.buffer

    def serve(self, name: str, service_class: Any, handler: Callable[[Any], Any]) -> Any:
        return self.node.advertise_service(name, service_class, handler)

    def client(self, name: str, service_class: Any, persistent: bool) -> Callable[..., Any]:
        self.node.wait_for_service(name)
        return self.node.service(name, service_class, persistent=persistent)


if __name__ == "__main__":
    library = Pyros1()
    try:
        play(library)
    finally:
        library.node.shutdown()
