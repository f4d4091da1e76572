"""Messages through the bridge of `pyros1 web` to a client: how many, and how late.

::

    python interop/bench/web_bridges.py [--seconds S] [--url ws://localhost:9090/]

prints a table. Publishers, client and server are processes of their own. *Messages per second*: what the client got
of a publisher in a tight loop, or at 30 Hz for images. *Latency*: from before `publish` to after the client has parsed
the message, one at a time, at 100 Hz (images: 30 Hz), in milliseconds.

With ``--url``, the same is measured through a server that runs elsewhere, such as rosbridge_server, on the system of
ROS_MASTER_URI. (Neither Debian nor PyPI has it for ROS 1.)
"""

from __future__ import annotations

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

SOURCE = Path(__file__).resolve().parents[2] / "src"
sys.path.insert(1, str(SOURCE))

from websockets.sync.client import ClientConnection, connect  # noqa: E402  after the path

from pyros1.master.server import Master  # noqa: E402

PUBLISHER = """
import sys, time
from pyros1.node import Node
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64, Header
from pyros1.ground.timing import Time

kind, topic, hz = sys.argv[1], sys.argv[2], float(sys.argv[3])
node = Node("bench_" + topic.strip("/"), argv=[], rosout=False)
publisher = node.advertise(topic, Image if kind == "image" else Float64, queue_size=10)
data = bytes(range(256)) * 3600  # 640 x 480, three bytes each
period = 1 / hz if hz else 0
at = time.time()
while node.ok():
    now = time.time()
    if kind == "image":
        publisher.publish(Image(Header(0, Time.from_sec(now), "eye"), 480, 640, "bgr8", 0, 1920, data))
    else:
        publisher.publish(now)
    if period:
        at = max(at + period, now)
        node.sleep(at - time.time()) if at > time.time() else None
"""
CASES = [
    ("Float64, JSON", "float", "none", 0, 100),
    ("Float64, CBOR", "float", "cbor", 0, 100),
    ("image of 640x480, JSON", "image", "none", 30, 30),
    ("image of 640x480, PNG", "image", "png", 30, 30),
    ("image of 640x480, CBOR", "image", "cbor", 30, 30),
    ("image of 640x480, CBOR-RAW", "image", "cbor-raw", 30, 30),
]


@contextmanager
def program(*words: str, **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Run a program while the context lasts."""
    process = subprocess.Popen([sys.executable, *words], text=True, stdin=subprocess.DEVNULL, **options)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(20)


def sent_at(frame: str | bytes) -> float:
    """Parse a frame as a client does, and return when its message was sent, or 0 if that takes a decoder of ROS."""
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
        return message["header"]["stamp"]["secs"] + message["header"]["stamp"]["nsecs"] / 1e9
    return float(message["data"])


def measure(socket_: ClientConnection, seconds: float) -> tuple[float, list[float]]:
    """Return messages per second, and latencies in seconds."""
    for _ in range(5):
        socket_.recv(timeout=20)
    late: list[float] = []
    start = time.monotonic()
    while time.monotonic() - start < seconds:
        frame = socket_.recv(timeout=20)
        sent = sent_at(frame)
        late.append(time.time() - sent)
    return len(late) / (time.monotonic() - start), sorted(late)


def run(url: str, kind: str, compression: str, hz: float, seconds: float) -> tuple[float, list[float]]:
    """Publish at a rate, 0 for as fast as it goes, and measure."""
    topic = f"/{kind}_{compression.replace('-', '_')}_{hz:g}"
    with program("-c", PUBLISHER, kind, topic, str(hz)), connect(url, max_size=None, max_queue=64) as socket_:
        name = "sensor_msgs/Image" if kind == "image" else "std_msgs/Float64"
        socket_.send(json.dumps({"op": "subscribe", "topic": topic, "type": name, "compression": compression}))
        return measure(socket_, seconds)


def table(url: str, seconds: float) -> None:
    """Print the table."""
    print("| messages | per second | latency, median (ms) | 99 % (ms) |\n|---|---|---|---|")
    for label, kind, compression, most, calm in CASES:
        rate, _ = run(url, kind, compression, most, seconds)
        _, late = run(url, kind, compression, calm, seconds)
        slow = late[int(len(late) * 0.99)]
        print(f"| {label} | {rate:,.0f} | {statistics.median(late) * 1e3:.2f} | {slow * 1e3:.2f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Messages through the bridge of `pyros1 web`.")
    parser.add_argument("--seconds", type=float, default=5.0, help="of each measurement")
    parser.add_argument("--url", help="another server, on the system of ROS_MASTER_URI")
    options = parser.parse_args()
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(SOURCE), os.environ.get("PYTHONPATH", "")]))
    if options.url:
        table(options.url, options.seconds)
        return
    master = Master(port=0, bind_host="127.0.0.1")
    master.start()
    os.environ.update(ROS_MASTER_URI=master.uri, ROS_HOSTNAME="localhost")
    try:
        web = program("-m", "pyros1", "web", "--port", "0", "--token", "", stdout=subprocess.PIPE)
        with web as server:
            assert server.stdout is not None
            match = re.search(r"browser: http(://localhost:\d+/)", server.stdout.readline())
            assert match is not None
            table("ws" + match[1], options.seconds)
    finally:
        master.stop()


if __name__ == "__main__":
    main()
