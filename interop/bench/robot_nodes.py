"""What a node of a robot takes of the processor at its usual rate.

    python3 interop/bench/robot_nodes.py --side ours|stock --work WORK [--seconds S]

The works are those of robot_works.py; needs pyros1 and defusedxml on PYTHONPATH. A process gives the node what it
needs, and hears what it publishes: with each message, it reads the processor time of the node's process. Prints a JSON
object: what a message costs, in the cheapest of a few short times, since what other programs do to the caches only adds
to it; times the usual rate, in percent of a core.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "peers"))

from harness import free_port, until  # found through the path above
from robot_works import PACKAGES, WORKS, Work
from stock_image_proc import overlay

from pyros1.master.server import Master
from pyros1.msgs import load_message
from pyros1.node import Node

CPU = "cpu"
SLICES = 4
SETTLING = 0.3  # seconds from the first message of each topic until the node's start no longer counts
NAMESPACE, NAME = "/robot", "tool"


class Feeder(threading.Thread):
    """Calls functions at their rates until it is stopped.

    Args:
        feeds: the functions, which get the seconds since the beginning, and their rates in Hz.
    """

    def __init__(self, feeds: list[tuple[Callable[[float], object], float]]) -> None:
        super().__init__(name="feeder", daemon=True)
        self._feeds = feeds
        self._stopping = threading.Event()

    def run(self) -> None:
        begun = time.monotonic()
        # Not all at the same moment, as the drivers of a robot are not.
        steps, shifts = [0] * len(self._feeds), [place / 1000 for place in range(len(self._feeds))]
        while True:
            due = [step / hz + shift for step, shift, (_, hz) in zip(steps, shifts, self._feeds, strict=True)]
            wait = max(0.0, begun + min(due) - time.monotonic()) if due else None
            if self._stopping.wait(wait):
                return
            place = due.index(min(due))
            publish, hz = self._feeds[place]
            publish(steps[place] / hz)
            steps[place] += 1

    def stop(self) -> None:
        """Stop, and wait for the end."""
        self._stopping.set()
        self.join()


def cpu_seconds(pid: int) -> float:
    """What all threads of a process have used so far, to the nanosecond.

    /proc counts in steps of 10 ms, too coarse for nodes that do little. This is the clock of clock_getcpuclockid(3).
    """
    return time.clock_gettime(~pid << 3 | 2)


class Heard:
    """What came from a node.

    Args:
        missing: topics on which nothing has come.

    Attributes:
        missing: the same.
        pid: the node's process.
        used: the seconds that it had used when each message came.
    """

    def __init__(self, missing: set[str]) -> None:
        self.missing = missing
        self.pid = 0
        self.used: list[float] = []

    def add(self, topic: str, message: Any) -> None:
        """Note that a message has come."""
        self.missing.discard(topic)
        self.used.append(cpu_seconds(self.pid))


def command(work: Work, side: str, values: dict[str, str]) -> tuple[list[str], dict[str, str]]:
    """The command line of the node, and the variables that it needs."""
    names = [f"__name:={NAME}", f"__ns:={NAMESPACE}"]
    if side == "ours":
        package, program, *args = work.ours
        script = PACKAGES / package / "scripts" / program

        return [sys.executable, str(script), *(arg.format(**values) for arg in args), *names], {}
    variables = overlay(Path(values["home"]) / "overlay") if work.stock.startswith("image_proc/") else {}
    return [f"/usr/lib/{work.stock}", *names], variables


def set_params(node: Any, work: Work, values: dict[str, str]) -> None:
    """Set the private parameters of the node, before it starts."""
    for name, value in work.params.items():
        node.params[f"{NAMESPACE}/{NAME}/{name}"] = value.format(**values) if isinstance(value, str) else value


def measure(work: Work, side: str, seconds: float) -> dict[str, float]:
    """Run a node, and return its figures.

    Args:
        work: what it does.
        side: ``ours`` or ``stock``.
        seconds: length of a slice; it is longer if the work makes fewer messages than one in that time.
    """
    with ExitStack() as stack:
        home = stack.enter_context(tempfile.TemporaryDirectory())
        values = {"home": home, "port": str(free_port()), "begun": str(time.time())}
        server = Master(port=0, bind_host="127.0.0.1")
        server.start()
        stack.callback(server.stop)
        environ = {**os.environ, "ROS_MASTER_URI": server.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": home}
        words = [f"__ns:={NAMESPACE}"]
        node = stack.enter_context(Node("bench", argv=words, environ=environ, handle_signals=False))
        set_params(node, work, values)
        heard = Heard(set(work.outputs))
        for topic, type_name in work.outputs.items():
            node.subscribe(topic, load_message(type_name), partial(heard.add, topic))
        line, variables = command(work, side, values)
        process = subprocess.Popen(line, env={**environ, **variables}, stdout=subprocess.DEVNULL)
        heard.pid = process.pid
        stack.callback(process.wait, 10)
        stack.callback(process.terminate)
        feeder = Feeder([(feed.open(node, values), feed.hz) for feed in work.feeds])
        feeder.start()
        stack.callback(feeder.stop)
        until(lambda: not heard.missing, f"something on each of {', '.join(work.outputs)}")
        time.sleep(SETTLING)
        if not work.hz:
            return {CPU: min(idle_share(process.pid, seconds) for _ in range(SLICES)) * 100}
        count, first = max(1, round(work.hz * seconds)), len(heard.used)
        until(lambda: len(heard.used) > first + SLICES * count, "enough messages")
        ends = heard.used[first::count]
        return {CPU: min(after - before for before, after in pairwise(ends)) / count * work.hz * 100}


def idle_share(pid: int, seconds: float) -> float:
    """The part of a core that a process uses for some time."""
    before = cpu_seconds(pid)
    time.sleep(seconds)
    return (cpu_seconds(pid) - before) / seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--side", choices=("ours", "stock"), default="ours")
    parser.add_argument("--work", choices=WORKS, required=True, metavar="WORK")
    parser.add_argument("--seconds", type=float, default=1.0)
    options = parser.parse_args()
    print(json.dumps(measure(WORKS[options.work], options.side, options.seconds)))


if __name__ == "__main__":
    main()
