"""What messages cost that `pyros1 web` sends to its clients, and another rosbridge server in turns.

::

    python interop/bench/web_bridges.py [--quick] [--seconds S] [--only WORDS]
                                        [--other COMMAND --other-url ws://localhost:9090/]

prints a table. Publisher, server, and clients are processes of their own. *CPU*: the server's processor time per
published message, in milliseconds. *Latency*: from before `publish` until the first client has parsed the message, in
milliseconds. The other clients only receive. COMMAND runs the other server, such as rosbridge_suite's (branch ros1,
with Debian's rospy), on the system of ROS_MASTER_URI. The rows of Foxglove viewers and of the server's own pages are
measured without it; a page gets only as many frames per second as it shows.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import shlex
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

SOURCE = Path(__file__).resolve().parents[2] / "src"
sys.path.insert(1, str(SOURCE))

from web_clients import CLIENTS, RosbridgeClient, receive_only  # noqa: E402  after the path

from pyros1.ground.timing import Time  # noqa: E402
from pyros1.master.server import Master  # noqa: E402
from pyros1.msgs import load_message  # noqa: E402
from pyros1.node import Node  # noqa: E402

FIELDS: dict[str, dict[str, Any]] = {
    "std_msgs/Float64": {},
    "sensor_msgs/LaserScan": {"ranges": [1 + i / 7 for i in range(720)], "intensities": [i / 3 for i in range(720)]},
    "sensor_msgs/Image": {
        "height": 480,
        "width": 640,
        "encoding": "bgr8",
        "step": 1920,
        "data": bytes(range(256)) * 3600,
    },
}


class Work(NamedTuple):
    """What is published, and how clients want it.

    Attributes:
        hz: messages per second.
        form: the compression of rosbridge, or one of the other `PROTOCOLS`.
        clients: how many there are.
    """

    type: str
    hz: float
    form: str
    clients: int = 1

    @property
    def label(self) -> str:
        """The row's name."""
        s = "s" if self.clients > 1 else ""
        return f"{self.type.rpartition('/')[2]}, {self.hz:g} Hz, {self.form}, {self.clients} client{s}"

    @property
    def is_rosbridge(self) -> bool:
        """Whether other servers have this, too."""
        return self.form not in ("foxglove", "page")


WORKS = [
    Work("std_msgs/Float64", 2000, "none"),
    Work("std_msgs/Float64", 2000, "cbor"),
    Work("sensor_msgs/LaserScan", 40, "none"),
    Work("sensor_msgs/LaserScan", 40, "cbor"),
    Work("sensor_msgs/Image", 30, "none"),
    Work("sensor_msgs/Image", 30, "png"),
    Work("sensor_msgs/Image", 30, "cbor"),
    Work("sensor_msgs/Image", 30, "cbor-raw"),
    Work("std_msgs/Float64", 100, "none", 10),
    Work("std_msgs/Float64", 100, "none", 60),
    Work("sensor_msgs/LaserScan", 20, "none", 10),
    Work("sensor_msgs/LaserScan", 20, "none", 60),
    Work("sensor_msgs/Image", 10, "cbor", 10),
    Work("sensor_msgs/Image", 5, "none", 10),
    Work("std_msgs/Float64", 2000, "foxglove"),
    Work("std_msgs/Float64", 100, "foxglove", 10),
    Work("std_msgs/Float64", 100, "foxglove", 60),
    Work("sensor_msgs/Image", 30, "foxglove"),
    Work("sensor_msgs/Image", 10, "foxglove", 10),
    Work("std_msgs/Float64", 2000, "page"),
    Work("std_msgs/Float64", 100, "page", 10),
    Work("std_msgs/Float64", 100, "page", 60),
    Work("sensor_msgs/Image", 30, "page"),
    Work("sensor_msgs/Image", 10, "page", 10),
]
QUICK = [Work("std_msgs/Float64", 500, form, 2) for form in ("none", "foxglove", "page")]
"""A row of each protocol, to see that they work."""


def publish(type_name: str, topic: str, hz: float) -> None:
    """Publish until the process is ended; each message has the time in it."""
    cls = load_message(type_name)
    with Node("bench_" + topic.strip("/"), argv=[], rosout=False) as node:
        publisher: Any = node.advertise(topic, cls, queue_size=100)
        message: Any = cls(**FIELDS[type_name])
        due = time.time()
        while node.ok():
            if type_name == "std_msgs/Float64":
                message.data = time.time()
            else:
                message.header.stamp = Time.from_sec(time.time())
            publisher.publish(message)
            due = max(due + 1 / hz, time.time())
            node.sleep(max(0.0, due - time.time()))


@contextmanager
def program(*words: str, **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Run a program while the context lasts."""
    process = subprocess.Popen(words, text=True, stdin=subprocess.DEVNULL, **options)
    try:
        yield process
    finally:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(20)
        process.kill()


def processor_time(pid: int) -> float:
    """Return what a process has used, in seconds.

    /proc counts ticks, which are wrong for processes that run briefly after each tick.
    """
    return time.clock_gettime(~pid << 3 | 2)  # as clock_getcpuclockid(3) does


def measure(url: str, pid: int, work: Work, seconds: float, settle: float) -> tuple[float, float, float]:
    """Return the server's milliseconds per message, and the median and 99 % of the latencies in milliseconds."""
    topic = f"/{work.type.rpartition('/')[2].lower()}_{work.form.replace('-', '_')}_{work.clients}_{pid}"
    with ExitStack() as stack:
        stack.enter_context(program(sys.executable, __file__, "--publish", work.type, topic, str(work.hz)))
        client = stack.enter_context(CLIENTS.get(work.form, RosbridgeClient)(url, topic, work.type, work.form))
        if work.clients > 1:
            words = (*client.for_others, str(work.clients - 1))
            stack.enter_context(program(sys.executable, __file__, "--receive", *words))
        settled = time.monotonic() + settle
        while time.monotonic() < settled:
            client.next_sent_at()
        late: list[float] = []
        start, used = time.monotonic(), processor_time(pid)
        while time.monotonic() - start < seconds:
            sent = client.next_sent_at()
            late.append(time.time() - sent)
        used = processor_time(pid) - used
        published = (time.monotonic() - start) * work.hz if work.form == "page" else len(late)
    late.sort()
    return used / published * 1e3, statistics.median(late) * 1e3, late[int(len(late) * 0.99)] * 1e3


def table(servers: dict[str, tuple[str, int]], works: list[Work], seconds: float, turns: int, settle: float) -> None:
    """Measure each work with all servers in turns, and print the medians."""
    columns = [f"{name}: CPU | median | 99 %" for name in servers]
    print(f"| messages | {' | '.join(columns)} | ratio of CPU |\n|{'---|' * (3 * len(servers) + 2)}")
    for work in works:
        used = servers if work.is_rosbridge else {"pyros1": servers["pyros1"]}
        results: dict[str, list[tuple[float, float, float]]] = {name: [] for name in used}
        for _ in range(turns):
            for name, (url, pid) in used.items():
                results[name].append(measure(url, pid, work, seconds, settle))
        medians = [[statistics.median(column) for column in zip(*each, strict=True)] for each in results.values()]
        cells = [f"{cpu:.3f} | {median:.2f} | {slow:.2f}" for cpu, median, slow in medians]
        cells += ["- | - | -"] * (len(servers) - len(used))
        ratio = f"{medians[0][0] / medians[1][0]:.2f}" if len(used) > 1 else "-"
        print(f"| {work.label} | {' | '.join(cells)} | {ratio} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Messages from `pyros1 web` to its clients.")
    parser.add_argument("--quick", action="store_true", help="a short run of a row of each protocol")
    parser.add_argument("--seconds", type=float, help="of each measurement (5; with --quick 0.3)")
    parser.add_argument("--turns", type=int, help="measurements of each server (3; with --quick 1)")
    parser.add_argument("--only", default="", help="measure only rows with this text")
    parser.add_argument("--other", help="command that runs another server")
    parser.add_argument("--other-url", default="ws://localhost:9090/", help="the other server's address")
    parser.add_argument("--publish", nargs=3, help=argparse.SUPPRESS)
    parser.add_argument("--receive", nargs=5, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.publish:
        publish(options.publish[0], options.publish[1], float(options.publish[2]))
        return
    if options.receive:
        receive_only(*options.receive[:-1], count=int(options.receive[-1]))
        return
    works = [work for work in (QUICK if options.quick and not options.only else WORKS) if options.only in work.label]
    if not works:
        parser.error(f"no row has {options.only!r} in its first column")
    seconds = options.seconds or (0.3 if options.quick else 5.0)
    turns = options.turns or (1 if options.quick else 3)
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(SOURCE), os.environ.get("PYTHONPATH", "")]))
    master = Master(port=0, bind_host="127.0.0.1")
    master.start()
    os.environ.update(ROS_MASTER_URI=master.uri, ROS_HOSTNAME="localhost")
    servers: dict[str, tuple[str, int]] = {}
    with ExitStack() as stack:
        stack.callback(master.stop)
        words = (sys.executable, "-m", "pyros1", "web", "--port", "0", "--token", "", "--max-pages", "100")
        ours = stack.enter_context(program(*words, stdout=subprocess.PIPE))
        assert ours.stdout is not None
        match = re.search(r"browser: http(://localhost:\d+/)", ours.stdout.readline())
        assert match is not None
        servers["pyros1"] = ("ws" + match[1], ours.pid)
        if options.other:
            other = stack.enter_context(program(*shlex.split(options.other), stdout=subprocess.DEVNULL))
            servers["other"] = (options.other_url, other.pid)
            address = urlsplit(options.other_url)
            until = time.monotonic() + 30
            while time.monotonic() < until:
                with contextlib.suppress(OSError), socket.create_connection((address.hostname, address.port)):
                    break
                time.sleep(0.2)
        table(servers, works, seconds, turns, settle=0.3 if options.quick else 1.5)


if __name__ == "__main__":
    main()
