"""Recording and playing of `pyros1 bag` beside the stock C++ programs'.

    python interop/bench/bags.py [--seconds S] [--rates HZ...] [--images MB] [--only record|play]

Record: a publisher sends std_msgs/Float64 at a rate, or images at 30 Hz, to our recorder and then to stock's; printed
is how many of the messages are not in the bag, and what the recorder took of a processor and of memory. Play: a bag
with a message every millisecond is played to a subscriber of ours, and its arrival times are compared with the bag's.
Exit code: 0; 1 if ours loses where stock loses none, or plays with a p99 error of 1 ms or more; 3 without stock ROS.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SOURCE = Path(__file__).resolve().parents[2] / "src"
STOCK_RECORD, STOCK_PLAY = "/usr/lib/rosbag/record", "/usr/lib/rosbag/play"
OURS = [sys.executable, "-m", "pyros1", "bag"]
TICK = 0.001
DEADLINE = 60.0


# Roles of child processes ---------------------------------------------------------------------------------------------


def publish(topic: str, rate: float, size: int, seconds: float) -> None:
    """Publish at a rate: Float64, or images of so many bytes; prints how many. Begins when somebody listens."""
    from pyros1 import Node

    with Node("load", anonymous=True, argv=[]) as node:
        message_class: Any = __import__("pyros1.msgs", fromlist=["load_message"]).load_message(
            "sensor_msgs/Image" if size else "std_msgs/Float64"
        )
        publisher: Any = node.advertise(topic, message_class, queue_size=20 if size else 20000)
        publisher.wait_for_subscribers(timeout=DEADLINE)
        message = message_class()
        if size:
            message.data = bytes(size)
        time.sleep(0.5)
        began, sent, total = time.perf_counter(), 0, int(rate * seconds)
        while sent < total:
            due = min(total, int((time.perf_counter() - began) * rate) + 1)
            while sent < due:
                sent += 1
                if not size:
                    message.data = float(sent)
                publisher.publish(message)
            time.sleep(max(TICK, began + sent / rate - time.perf_counter()) if rate < 1 / TICK else TICK)
        time.sleep(1.0)
        print(sent, publisher.dropped, flush=True)


def listen(topic: str, count: int) -> None:
    """Print the arrival times of so many messages, in seconds, with their values."""
    import threading

    from pyros1 import Node

    arrived: list[tuple[float, float]] = []
    done = threading.Event()

    def take(message: Any) -> None:
        arrived.append((time.perf_counter(), message.data))
        if len(arrived) == count:
            done.set()

    with Node("ear", anonymous=True, argv=[]) as node:
        node.subscribe(topic, "std_msgs/Float64", take)
        print("ready", flush=True)
        done.wait(DEADLINE)
    for moment, value in arrived:
        print(f"{moment:.7f} {value!r}")


# The parent -----------------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def system(folder: Path) -> Iterator[dict[str, str]]:
    """A master on a free port; yields the environment of its nodes."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    env = {
        **os.environ,
        "ROS_MASTER_URI": f"http://localhost:{port}",
        "ROS_HOSTNAME": "localhost",
        "ROS_HOME": str(folder / "ros"),
        "PYTHONPATH": f"{SOURCE}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
    }
    with subprocess.Popen(
        [sys.executable, "-m", "pyros1", "core", "-p", str(port)], env=env, stdout=subprocess.DEVNULL
    ) as core:
        try:
            end = time.monotonic() + DEADLINE
            while time.monotonic() < end:
                with contextlib.suppress(OSError), socket.create_connection(("localhost", port), 1.0):
                    break
                time.sleep(0.05)
            yield env
        finally:
            core.send_signal(signal.SIGINT)
            core.wait(DEADLINE)


def role(name: str, *words: object, env: dict[str, str], **options: Any) -> subprocess.Popen[str]:
    """Start this file in a role."""
    command = [sys.executable, __file__, "--role", name, *map(str, words)]
    return subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True, **options)


def record(command: list[str], env: dict[str, str], bag: Path, rate: float, size: int, seconds: float) -> str:
    """Record a load; return a row's cell: messages missing of those sent, the recorder's share of a processor."""
    with subprocess.Popen(
        [*command, "-O", str(bag), "/load"], env=env, stdout=subprocess.DEVNULL, cwd=bag.parent
    ) as recorder:
        try:
            with role("publish", "/load", rate, size, seconds, env=env) as load:
                assert load.stdout is not None
                sent, dropped = map(int, load.stdout.readline().split())
                load.wait(DEADLINE)
            memory = peak_memory(recorder.pid)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            recorder.send_signal(signal.SIGINT)
            recorder.wait(DEADLINE)
        finally:
            recorder.kill()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    lost = sent - messages_of(bag)
    bag.unlink()
    by_publisher = f" ({dropped} by the publisher)" if dropped else ""
    return f"{lost} of {sent} lost{by_publisher}, {100 * used / seconds:.0f}% CPU, {memory:.0f} MB"


def peak_memory(pid: int) -> float:
    """The most memory that a process has had, in MB."""
    for line in Path(f"/proc/{pid}/status").read_text(encoding="utf-8").split("\n"):
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) / 1e3
    return 0.0


def messages_of(bag: Path) -> int:
    """The number of messages in a bag."""
    sys.path.insert(0, str(SOURCE))
    from pyros1.bag.reader import BagReader

    with BagReader(bag) as reader:
        return reader.count()


def make_regular_bag(path: Path, seconds: float, rate: float = 1000.0) -> int:
    """Write a bag with a Float64 every 1/rate seconds; return their number."""
    sys.path.insert(0, str(SOURCE))
    from pyros1.bag.container import BagWriter
    from pyros1.msgs import load_message

    cls: Any = load_message("std_msgs/Float64")
    header = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, "callerid": "/load"}
    count = int(seconds * rate)
    with BagWriter(path) as bag:
        conn = bag.add_connection("/load", {name: value.encode() for name, value in header.items()})
        for number in range(count):
            offset = int(number * 1e9 / rate)
            bag.write(conn, 1_700_000_000_000_000_000 + offset, cls._encode(cls(offset / 1e9)))
    return count


def play(command: list[str], env: dict[str, str], bag: Path, count: int) -> tuple[float, float, float]:
    """Play a bag; return how late its messages came, in ms: median, p99 and worst, beside the line that fits best."""
    with role("listen", "/load", count, env=env) as ear:
        assert ear.stdout is not None
        ear.stdout.readline()
        subprocess.run(
            [*command, "-d", "1", str(bag)],
            env=env, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=DEADLINE,
        )  # fmt: skip
        lines = ear.communicate(timeout=DEADLINE)[0].split("\n")
    came = [(float(moment), float(value)) for moment, value in (line.split() for line in lines if line)]
    offsets = sorted(moment - value for moment, value in came)
    typical = offsets[len(offsets) // 2]
    errors = sorted(abs(offset - typical) * 1e3 for offset in offsets)
    if len(came) < count:
        print(f"  only {len(came)} of {count} messages came", file=sys.stderr)
    return errors[len(errors) // 2], errors[int(len(errors) * 0.99)], errors[-1]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Recording and playing, beside stock's.")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--rates", type=float, nargs="*", default=[1000, 20000, 50000])
    parser.add_argument("--images", type=float, default=6.2, help="size in MB; 0 for none")
    parser.add_argument("--only", choices=["record", "play"])
    parser.add_argument("--role", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.role:
        name, topic, *numbers = options.role
        if name == "publish":
            publish(topic, float(numbers[0]), int(numbers[1]), float(numbers[2]))
        else:
            listen(topic, int(numbers[0]))
        return 0
    if not Path(STOCK_RECORD).exists():
        print("stock rosbag is not installed; run interop/setup", file=sys.stderr)
        return 3
    failed = False
    with tempfile.TemporaryDirectory() as name, system(Path(name)) as env:
        folder = Path(name)
        if options.only != "play":
            loads = [(rate, 0) for rate in options.rates]
            loads += [(30.0, int(options.images * 1e6))] if options.images else []
            for rate, size in loads:
                what = f"{size / 1e6:g} MB at {rate:g} Hz" if size else f"Float64 at {rate:g} Hz"
                ours = record([*OURS, "record"], env, folder / "ours.bag", rate, size, options.seconds)
                stock = record([STOCK_RECORD], env, folder / "stock.bag", rate, size, options.seconds)
                print(f"record {what:22} pyros1: {ours:52} stock: {stock}", flush=True)
                failed = failed or (stock.startswith("0 ") and not ours.startswith("0 "))
        if options.only != "record":
            count = make_regular_bag(folder / "regular.bag", options.seconds)
            for who, command in (("pyros1", [*OURS, "play"]), ("stock", [STOCK_PLAY])):
                median, p99, worst = play(command, env, folder / "regular.bag", count)
                print(f"play 1 kHz {who:7} error median {median:.3f} ms, p99 {p99:.3f} ms, worst {worst:.3f} ms")
                failed = failed or (who == "pyros1" and p99 >= 1.0)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
