"""What messages cost that a rosbridge server sends to its clients: `pyros1 web`, and another server in turns.

::

    python interop/bench/web_bridges.py [--seconds S] [--other COMMAND --other-url ws://localhost:9090/]

prints a table. Publisher, server, and clients are processes of their own. *CPU*: the server's processor time per
published message, in milliseconds. *Latency*: from before `publish` until the first client has parsed the message, in
milliseconds. The other clients only receive. COMMAND runs the other server, such as rosbridge_suite's (branch ros1,
with Debian's rospy), on the system of ROS_MASTER_URI.
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import json
import os
import re
import selectors
import shlex
import socket
import statistics
import struct
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

from websockets.sync.client import connect  # noqa: E402  after the path

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
    """What is published, and how clients want it."""

    type: str
    hz: float
    compression: str
    clients: int = 1


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
]


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


def receive_only(url: str, request: str, count: int) -> None:
    """Be several clients that discard what they receive, but answer pings."""
    selector = selectors.DefaultSelector()
    for _ in range(count):
        link = socket.create_connection((urlsplit(url).hostname, urlsplit(url).port))
        key = base64.b64encode(os.urandom(16)).decode()
        link.sendall(
            f"GET {urlsplit(url).path} HTTP/1.1\r\nHost: {urlsplit(url).netloc}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        buffer = bytearray()
        while b"\r\n\r\n" not in buffer:
            buffer += link.recv(4096)
        del buffer[: buffer.index(b"\r\n\r\n") + 4]
        link.sendall(masked(0x81, request.encode()))
        selector.register(link, selectors.EVENT_READ, (buffer, [0]))
    while True:
        for key_and_data, _ in selector.select():
            link, (buffer, skip) = key_and_data.fileobj, key_and_data.data  # type: ignore[assignment]
            data = link.recv(1 << 20)
            if not data:
                return
            buffer += data
            for ping in pings(buffer, skip):
                link.sendall(masked(0x8A, ping))


def masked(first: int, payload: bytes) -> bytes:
    """Return a client's frame."""
    size = bytes((0x80 | len(payload),)) if len(payload) < 126 else struct.pack(">BH", 0x80 | 126, len(payload))
    return bytes((first,)) + size + bytes(4) + payload


def pings(buffer: bytearray, skip: list[int]) -> Iterator[bytes]:
    """Remove frames from a buffer, and yield the payloads of pings; ``skip``: bytes missing of the last frame."""
    while True:
        gone = min(skip[0], len(buffer))
        del buffer[:gone]
        skip[0] -= gone
        if skip[0] or len(buffer) < 2:
            return
        size, start = buffer[1], 2
        if size >= 126:
            start = 4 if size == 126 else 10
            if len(buffer) < start:
                return
            size = int.from_bytes(buffer[2:start], "big")
        if buffer[0] == 0x89:
            if len(buffer) < start + size:
                return
            yield bytes(buffer[start : start + size])
        skip[0] = start + size


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


def sent_at(frame: str | bytes) -> float:
    """Parse a frame as a client does, and return when its message was sent."""
    if isinstance(frame, str):
        value = json.loads(frame)
        if value["op"] == "png":
            from pyros1.web.rosbridge import png

            value = json.loads(png.unpack(value["data"], 1 << 26))
    else:
        import cbor2

        value = cbor2.loads(frame)
    message = value["msg"]
    if "bytes" in message:
        return int.from_bytes(message["bytes"][4:8], "little") + int.from_bytes(message["bytes"][8:12], "little") / 1e9
    if "header" in message:
        return float(message["header"]["stamp"]["secs"] + message["header"]["stamp"]["nsecs"] / 1e9)
    return float(message["data"])


def processor_time(pid: int) -> float:
    """Return what a process has used, in seconds.

    /proc counts ticks, which are wrong for processes that run briefly after each tick.
    """
    return time.clock_gettime(~pid << 3 | 2)  # as clock_getcpuclockid(3) does


def measure(url: str, pid: int, work: Work, seconds: float) -> tuple[float, float, float]:
    """Return the server's milliseconds per message, and the median and 99 % of the latencies in milliseconds."""
    topic = f"/{work.type.rpartition('/')[2].lower()}_{work.compression.replace('-', '_')}_{work.clients}_{pid}"
    request = json.dumps({"op": "subscribe", "topic": topic, "type": work.type, "compression": work.compression})
    me = Path(__file__).resolve()
    with ExitStack() as stack:
        stack.enter_context(program(sys.executable, str(me), "--publish", work.type, topic, str(work.hz)))
        if work.clients > 1:
            stack.enter_context(program(sys.executable, str(me), "--receive", url, request, str(work.clients - 1)))
        client = stack.enter_context(connect(url, max_size=None, max_queue=64, compression=None))
        client.send(request)
        settled = time.monotonic() + 1.5
        while time.monotonic() < settled:
            client.recv(timeout=20)
        late: list[float] = []
        start, used = time.monotonic(), processor_time(pid)
        while time.monotonic() - start < seconds:
            sent = sent_at(client.recv(timeout=20))
            late.append(time.time() - sent)
        used = processor_time(pid) - used
    late.sort()
    return used / len(late) * 1e3, statistics.median(late) * 1e3, late[int(len(late) * 0.99)] * 1e3


def table(servers: dict[str, tuple[str, int]], seconds: float, turns: int, only: str) -> None:
    """Measure each work with all servers in turns, and print the medians."""
    columns = [f"{name}: CPU | median | 99 %" for name in servers]
    print(f"| messages | {' | '.join(columns)} | ratio of CPU |\n|{'---|' * (3 * len(servers) + 2)}")
    for work in WORKS:
        label = f"{work.type.rpartition('/')[2]}, {work.hz:g} Hz, {work.compression}, {work.clients} clients"
        if only not in label:
            continue
        results: dict[str, list[tuple[float, float, float]]] = {name: [] for name in servers}
        for _ in range(turns):
            for name, (url, pid) in servers.items():
                results[name].append(measure(url, pid, work, seconds))
        medians = [[statistics.median(column) for column in zip(*each, strict=True)] for each in results.values()]
        cells = " | ".join(f"{cpu:.2f} | {median:.2f} | {slow:.2f}" for cpu, median, slow in medians)
        print(f"| {label} | {cells} | {medians[0][0] / medians[-1][0]:.2f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Messages through the rosbridge server of `pyros1 web`.")
    parser.add_argument("--seconds", type=float, default=5.0, help="of each measurement")
    parser.add_argument("--turns", type=int, default=3, help="measurements of each server")
    parser.add_argument("--only", default="", help="measure only rows with this text")
    parser.add_argument("--other", help="command that runs another server")
    parser.add_argument("--other-url", default="ws://localhost:9090/", help="the other server's address")
    parser.add_argument("--publish", nargs=3, help=argparse.SUPPRESS)
    parser.add_argument("--receive", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.publish:
        publish(options.publish[0], options.publish[1], float(options.publish[2]))
        return
    if options.receive:
        receive_only(options.receive[0], options.receive[1], int(options.receive[2]))
        return
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
        table(servers, options.seconds, options.turns, options.only)


if __name__ == "__main__":
    main()
