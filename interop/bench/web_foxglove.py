"""Latency and throughput of the Foxglove protocol of ``pyros1 web``: publisher -> server -> viewer, each a process.

``python interop/bench/web_foxglove.py [--seconds S]`` prints a table. The viewer reads from a bare socket, so that the
server is measured and not a client. Latency: from just before publishing until the whole message is there.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pyros1 import Node
from pyros1.master.server import Master
from pyros1.msgs import load_message

TICKS = os.sysconf("SC_CLK_TCK")


class Work(NamedTuple):
    """What is published, and how fast it is read.

    Attributes:
        hz: messages per second; 0: as many as possible.
        size: bytes of the data of a message.
        reading: bytes per second that the viewer reads; 0: all that come.
    """

    name: str
    type: str
    hz: float
    size: int
    reading: float


WORKS = [
    Work("Image 640x480, 30 Hz", "sensor_msgs/Image", 30, 640 * 480 * 3, 0),
    Work("PointCloud2 10 MB, 10 Hz", "sensor_msgs/PointCloud2", 10, 10_000_000, 0),
    Work("Float64, 1 kHz", "std_msgs/Float64", 1000, 8, 0),
    Work("Float64, full speed", "std_msgs/Float64", 0, 8, 0),
    Work("Image, viewer reads 5 MB/s", "sensor_msgs/Image", 30, 640 * 480 * 3, 5e6),
    Work("PointCloud2, viewer reads 20 MB/s", "sensor_msgs/PointCloud2", 10, 10_000_000, 20e6),
]


def publish(number: int, seconds: float) -> None:
    """Publish for some seconds; print how often."""
    work = WORKS[number]
    with Node("publisher", argv=[], handle_signals=False, rosout=False) as node:
        publisher: Any = node.advertise("bench", work.type, queue_size=2 if work.size > 1000 else 1000)
        message: Any = load_message(work.type)()
        if work.size > 8:
            message.data = os.urandom(work.size)
        publisher.wait_for_subscribers(timeout=30)
        time.sleep(0.5)
        count = 0
        start = time.monotonic()
        while (now := time.monotonic() - start) < seconds:
            if work.hz and count / work.hz > now:
                time.sleep(count / work.hz - now)
            stamp = time.time()
            if work.size == 8:
                message.data = stamp
            else:
                message.header.stamp.secs, message.header.stamp.nsecs = int(stamp), int(stamp % 1 * 1e9)
            publisher.publish(message)
            count += 1
        time.sleep(0.5)
        print(count, flush=True)


class Viewer:
    """A viewer on a bare socket, which reads no faster than it is told."""

    def __init__(self, port: int, reading: float) -> None:
        self._socket = socket.socket()
        if reading:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 16)
        self._socket.connect(("127.0.0.1", port))
        self._socket.settimeout(1.0)
        self._reading = reading
        self._start = time.monotonic()
        self._received = 0
        self._buffer = bytearray()
        self._socket.sendall(
            b"GET /?token=t HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
            b"Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n"
        )
        while b"\r\n\r\n" not in self._buffer:
            self._buffer += self._socket.recv(4096)
        del self._buffer[: self._buffer.index(b"\r\n\r\n") + 4]

    def subscribe(self, topic: str) -> None:
        """Subscribe as soon as there is the topic."""
        while True:
            for frame in self.frames():
                if frame[:1] == b"{":
                    for channel in json.loads(frame).get("channels", ()):
                        if channel["topic"] == topic:
                            pairs = [{"id": 1, "channelId": channel["id"]}]
                            self._send(json.dumps({"op": "subscribe", "subscriptions": pairs}).encode())
                            return

    def _send(self, text: bytes) -> None:
        assert len(text) < 126
        self._socket.sendall(bytes([0x81, 0x80 | len(text)]) + bytes(4) + text)  # masked with zeros

    def frames(self) -> Iterator[bytes]:
        """Yield the frames that come; end after a second without any."""
        while True:
            if self._reading:
                early = self._received / self._reading - (time.monotonic() - self._start)
                if early > 0:
                    time.sleep(early)
            try:
                data = self._socket.recv(1 << 16 if self._reading else 1 << 20)
            except TimeoutError:
                return
            if not data:
                return
            self._received += len(data)
            self._buffer += data
            yield from self._complete()

    def _complete(self) -> Iterator[bytes]:
        buffer, place = self._buffer, 0
        while len(buffer) - place >= 2:
            size, head = buffer[place + 1], 2
            if size == 126 and len(buffer) - place >= 4:
                size, head = int.from_bytes(buffer[place + 2 : place + 4], "big"), 4
            elif size == 127 and len(buffer) - place >= 10:
                size, head = int.from_bytes(buffer[place + 2 : place + 10], "big"), 10
            elif size >= 126:
                break
            if len(buffer) - place < head + size:
                break
            yield bytes(buffer[place + head : place + head + min(size, 64 if size > 10_000 else size)])
            place += head + size
        del buffer[:place]

    def close(self) -> None:
        """Go."""
        self._socket.close()


def usage(pid: int) -> tuple[float, float]:
    """Return the seconds of CPU time that a process has used, and its memory in MB."""
    fields = Path(f"/proc/{pid}/stat").read_text("ascii").rpartition(")")[2].split()
    memory = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{pid}/status").read_text("ascii"))
    return (int(fields[11]) + int(fields[12])) / TICKS, int(memory[1]) / 1000 if memory else 0.0


def latency_of(work: Work, frame: bytes) -> float:
    """Return the age of a message in seconds."""
    if work.size == 8:
        return float(time.time() - struct.unpack_from("<d", frame, 13)[0])
    seconds, nanoseconds = struct.unpack_from("<II", frame, 17)
    return float(time.time() - seconds - nanoseconds * 1e-9)


def measure(number: int, seconds: float) -> list[str]:
    """Return a row of the table."""
    work = WORKS[number]
    with contextlib.ExitStack() as ends, tempfile.TemporaryDirectory() as home:
        master = Master(port=0, bind_host="127.0.0.1")
        master.start()
        ends.callback(master.stop)
        environ = {**os.environ, "ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": home}
        command = [sys.executable, "-m", "pyros1", "web", "--port", "0", "--token", "t"]
        web = subprocess.Popen(command, env=environ, stdout=subprocess.PIPE, text=True)
        ends.callback(lambda: (web.terminate(), web.wait(10)))
        assert web.stdout is not None
        port = int(re.search(r":(\d+)/\?token", web.stdout.readline())[1])  # type: ignore[index]
        role = subprocess.Popen(
            [sys.executable, __file__, "--publish", str(number), "--seconds", str(seconds)],
            env=environ,
            stdout=subprocess.PIPE,
            text=True,
        )
        ends.callback(lambda: (role.kill(), role.wait(10)))
        viewer = Viewer(port, work.reading)
        ends.callback(viewer.close)
        viewer.subscribe("/bench")
        ages, cpu, peak, first, last = [], usage(web.pid)[0], 0.0, 0.0, 0.0
        while role.poll() is None:
            for frame in viewer.frames():
                if frame[:1] == b"\x01":
                    ages.append(latency_of(work, frame))
                    last = time.monotonic()
                    first = first or last
                    if len(ages) % 1000 == 1 or work.size > 8:
                        peak = max(peak, usage(web.pid)[1])
        used = usage(web.pid)[0] - cpu
        assert role.stdout is not None
        published = int(role.stdout.readline())
    spent = max(last - first, 1e-9)
    ages.sort()
    figures = [statistics.median(ages), ages[int(len(ages) * 0.99)], ages[-1]]
    return [
        work.name,
        f"{published / seconds:,.0f}",
        f"{len(ages) / spent:,.0f}",
        f"{len(ages) / published:.0%}",
        f"{len(ages) * work.size / spent / 1e6:,.1f}",
        *(f"{each * 1000:,.1f}" for each in figures),
        f"{used / spent:.0%}",
        f"{peak:,.0f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--only", type=int, nargs="*", default=range(len(WORKS)), help="numbers of rows")
    parser.add_argument("--publish", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.publish is not None:
        publish(options.publish, options.seconds)
        return
    titles = ["work", "sent/s", "seen/s", "seen", "MB/s", "median ms", "99% ms", "most ms", "CPU", "memory MB"]
    rows = [titles]
    for number in options.only:
        rows.append(measure(number, options.seconds))
    widths = [max(len(row[place]) for row in rows) for place in range(len(titles))]
    rows.insert(1, ["-" * width for width in widths])
    for row in rows:
        print("| " + " | ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)) + " |")


if __name__ == "__main__":
    main()
