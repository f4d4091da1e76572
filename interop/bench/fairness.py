"""Print how many messages a subscriber gets from each of several publishers, for each kind of queue.

::

    python interop/bench/fairness.py [--seconds S]

Two publishers in processes of their own and one within the subscriber's process publish as fast as they can; another
one, that comes later, publishes 100 times in a second, and so does one within the process. The callback takes 50 µs.
Nobody may get nothing, and the two that publish slowly should lose little. Needs no stock ROS.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

SOURCE = str(Path(__file__).resolve().parents[2] / "src")
sys.path.insert(0, SOURCE)

import pyros1  # noqa: E402  found through the path above
from pyros1.master.server import Master  # noqa: E402

TYPE = "std_msgs/Float64"
FLOODS, LATE, INSIDE, INSIDE_SLOW = (1, 2), 3, 4, 5
CALLBACK = 50e-6
COLUMNS = ("flood 1", "flood 2", "late, 100 Hz", "flood inside", "inside, 100 Hz")


def publish(number: int, rate: float) -> None:
    """Publish a number for ever, as a program of its own; with rate 0 as fast as can be."""
    with pyros1.Node("publisher", anonymous=True, argv=[], rosout=False) as node:
        publisher = node.advertise("numbers", TYPE, queue_size=100 if rate else None)
        beat = node.rate(rate) if rate else None
        while node.ok():
            publisher.publish(number)
            if beat is not None:
                beat.sleep()


@contextmanager
def programs(*jobs: tuple[int, float]) -> Iterator[None]:
    """Run publishers in processes of their own."""
    started = [
        subprocess.Popen([sys.executable, __file__, "--publish", str(number), str(rate)]) for number, rate in jobs
    ]
    try:
        yield
    finally:
        for process in started:
            process.terminate()
        for process in started:
            process.wait()


def measure(callbacks: Any, queue_size: int | None, seconds: float) -> list[int]:
    """Return the messages that came from each publisher."""
    counts: Counter[float] = Counter()

    def count(message: Any) -> None:
        until = time.perf_counter() + CALLBACK
        while time.perf_counter() < until:
            pass
        counts[message.data] += 1

    with (
        pyros1.Node("subscriber", callbacks=callbacks, argv=[], handle_signals=False) as node,
        pyros1.Node("inside", argv=[], handle_signals=False) as inside,
    ):
        ended = threading.Event()
        subscriber = node.subscribe("numbers", TYPE, count, queue_size=queue_size)
        threads = [threading.Thread(target=node.spin)]

        def flood() -> None:
            publisher = inside.advertise("numbers", TYPE, queue_size=None)
            while not ended.is_set():
                publisher.publish(INSIDE)

        def slow() -> None:
            with pyros1.Node("slow", argv=[], handle_signals=False) as other:
                publisher = other.advertise("numbers", TYPE)
                while not ended.wait(0.01):
                    publisher.publish(INSIDE_SLOW)

        threads += [threading.Thread(target=flood), threading.Thread(target=slow)]
        for thread in threads:
            thread.start()
        with programs(*((number, 0.0) for number in FLOODS)):
            subscriber.wait_for_publishers(4, 20.0)
            with programs((LATE, 100.0)):
                subscriber.wait_for_publishers(5, 20.0)
                counts.clear()
                time.sleep(seconds)
                got = [counts[number] for number in (*FLOODS, LATE, INSIDE, INSIDE_SLOW)]
        ended.set()
        node.shutdown()
        for thread in threads:
            thread.join()
    return got


def main() -> int:
    parser = argparse.ArgumentParser(description="Messages per publisher for each kind of queue.")
    parser.add_argument("--seconds", type=float, default=2.0, help="length of each measurement (default 2)")
    parser.add_argument("--publish", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.publish:
        publish(int(options.publish[0]), float(options.publish[1]))
        return 0
    master = Master(port=0, bind_host="127.0.0.1")
    master.start()
    os.environ.update(ROS_MASTER_URI=master.uri, ROS_HOSTNAME="localhost", PYTHONPATH=SOURCE)
    print("| callbacks | queue_size |", " | ".join(COLUMNS), "|")
    print("|---" * (2 + len(COLUMNS)) + "|")
    starved = False
    for callbacks in ("inline", "spin"):
        for queue_size in (None, 1, 10):
            got = measure(callbacks, queue_size, options.seconds)
            starved = starved or not all(got)
            print(f"| {callbacks} | {queue_size} |", " | ".join(f"{count:,}" for count in got), "|", flush=True)
    master.stop()
    return int(starved)


if __name__ == "__main__":
    sys.exit(main())
