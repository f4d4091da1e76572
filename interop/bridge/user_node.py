"""The nodes of users at both ends of what `cost.py` measures, each in a process of its own.

`python user_node.py publish /a` publishes as many messages as each line of its input says: bytes, messages per second
and seconds. `python user_node.py subscribe /red/a /blue/a` answers each line with the number of messages that have
come.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import pyros1


def publish(node: pyros1.Node, topic: str) -> None:
    """Publish until the input ends."""
    publisher: Any = node.advertise(topic, "std_msgs/String", queue_size=10)
    print("ready" if publisher.wait_for_subscribers(1, 60) else "nobody subscribes", flush=True)
    for line in sys.stdin:
        size, rate, seconds = map(float, line.split())
        body = "x" * (int(size) - 4)
        start = time.monotonic()
        for number in range(int(seconds * rate)):
            time.sleep(max(0.0, start + number / rate - time.monotonic()))
            publisher.publish(body)
        print("done", flush=True)


def subscribe(node: pyros1.Node, topics: list[str]) -> None:
    """Count until the input ends."""
    count = 0

    def on_message(_: Any) -> None:
        nonlocal count
        count += 1

    for topic in topics:
        node.subscribe(topic, "std_msgs/String", on_message)
    for _ in sys.stdin:
        print(count, flush=True)


def main() -> None:
    """Publish or subscribe."""
    with pyros1.Node("user", argv=[], handle_signals=False) as node:
        if sys.argv[1] == "publish":
            publish(node, sys.argv[2])
        else:
            subscribe(node, sys.argv[2:])


if __name__ == "__main__":
    main()
