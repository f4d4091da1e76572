"""Recording, playing and reading: `pyros1 bag` beside stock's rosbag, whose recorder and player are C++ programs.

    python interop/bench/bags.py [--seconds S] [--only WORDS]             # both, taking turns, as a table
    python interop/bench/bags.py --side SIDE --work WORK [...]            # the figures of one, as JSON

Record: a publisher sends std_msgs/Float64 at a rate, or as fast as it can, or images at 30 Hz; said is how many of the
messages are in the bag (of a flood, how many per second), and what the recorder took of a processor and of
memory. Play: a bag with a message every millisecond, or 20, is played to a subscriber of ours, whose arrival times are
compared with the bag's. Info and reading: see bag_reading.py. Needs two processors and a quiet machine. Exit code: 0; 1
if ours loses where stock loses none, or plays with a p99 error of 1 ms or more at 1 kHz; 3 without stock ROS.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any

from bag_reading import connection_header, info_time, reading_rate

SOURCE = Path(__file__).resolve().parents[2] / "src"
OURS = [sys.executable, "-m", "pyros1", "bag"]
COMMANDS = {
    "ours": {"record": [*OURS, "record"], "play": [*OURS, "play"]},
    "stock": {"record": ["/usr/lib/rosbag/record"], "play": ["/usr/lib/rosbag/play"]},
}
LOADS = {
    "Float64 at 1 kHz": (1e3, 0),
    "Float64 at 20 kHz": (2e4, 0),
    "Float64 at 50 kHz": (5e4, 0),
    "Float64 in a flood": (inf, 0),
    "6.2 MB at 30 Hz": (30.0, 1920 * 1080 * 3),
}
"""What is recorded: messages per second, and bytes of an image; 0 for Float64."""
PLAYS = {"play": 1e3, "play at 20 kHz": 2e4}
"""What is played: messages per second."""
INFO = "info of 10 GB"
READ = {"read Float64": "std_msgs/Float64", "read Imu": "sensor_msgs/Imu"}
WORKS = (*LOADS, *PLAYS, INFO, *READ)
SIDES = ("ours", "stock", "rosbags")
"""rosbags only reads."""
RATE, KEPT, CPU, MEMORY = "recorded", "in the bag", "CPU", "memory"
MEDIAN, P99, WORST = "error, median", "error, p99", "error, worst"
TIME, READING = "time", "messages"
UNITS = {
    RATE: "/s", KEPT: "%", CPU: "%", MEMORY: "MB",
    MEDIAN: "ms", P99: "ms", WORST: "ms",
    TIME: "s", READING: "/s",
}  # fmt: skip
TICK = 0.001
DEADLINE = 60.0


# Roles of child processes ---------------------------------------------------------------------------------------------


def publish(topic: str, rate: float, size: int, seconds: float) -> None:
    """Publish at a rate: Float64, or images of so many bytes; prints how many. Begins when somebody listens."""
    from pyros1 import Node
    from pyros1.msgs import load_message

    with Node("load", anonymous=True, argv=[]) as node:
        message_class: Any = load_message("sensor_msgs/Image" if size else "std_msgs/Float64")
        publisher: Any = node.advertise(topic, message_class, queue_size=20 if size else 20000)
        publisher.wait_for_subscribers(timeout=DEADLINE)
        message = message_class()
        if size:
            message.data = bytes(size)
        time.sleep(0.5)
        began, sent = time.perf_counter(), 0
        while rate == inf and time.perf_counter() < began + seconds:
            for _ in range(100):
                sent += 1
                message.data = float(sent)
                publisher.publish(message)
        total = 0 if rate == inf else int(rate * seconds)
        while sent < total:
            due = min(total, int((time.perf_counter() - began) * rate) + 1)
            while sent < due:
                sent += 1
                if not size:
                    message.data = float(sent)
                publisher.publish(message)
            time.sleep(max(TICK, began + sent / rate - time.perf_counter()) if rate < 1 / TICK else TICK)
        print(sent, flush=True)
        time.sleep(1.0)


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


def record(
    command: list[str], env: dict[str, str], bag: Path, rate: float, size: int, seconds: float
) -> dict[str, float]:
    """Record a load; return the figures. The recorder may finish what it holds when the load has ended."""
    with subprocess.Popen(
        [*command, "-O", str(bag), "/load"], env=env, stdout=subprocess.DEVNULL, cwd=bag.parent
    ) as recorder:
        try:
            with role("publish", "/load", rate, size, seconds, env=env) as load:
                assert load.stdout is not None
                sent = int(load.stdout.readline())
                ended = time.perf_counter()
                if rate < inf:
                    load.wait(DEADLINE)
                memory = peak_memory(recorder.pid)
                recorder.send_signal(signal.SIGINT)
                _, _, usage = os.wait4(recorder.pid, 0)
                took = seconds + time.perf_counter() - ended
                recorder.returncode = 0
                load.wait(DEADLINE)
        finally:
            recorder.kill()
    found = messages_of(bag)
    bag.unlink()
    figures = {CPU: 100 * (usage.ru_utime + usage.ru_stime) / took, MEMORY: memory}
    return {RATE: found / took, **figures} if rate == inf else {KEPT: 100 * found / sent, **figures}


def peak_memory(pid: int) -> float:
    """The most memory that a process has had, in MB."""
    for line in Path(f"/proc/{pid}/status").read_text(encoding="utf-8").split("\n"):
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) / 1e3
    return 0.0


def messages_of(bag: Path) -> int:
    """The number of messages in a bag."""
    from pyros1.bag.format.reader import BagReader

    with BagReader(bag) as reader:
        return reader.count()


def make_regular_bag(path: Path, seconds: float, rate: float) -> int:
    """Write a bag with a Float64 every 1/rate seconds; return their number."""
    from pyros1.bag.format.writer import BagWriter
    from pyros1.msgs import load_message

    cls: Any = load_message("std_msgs/Float64")
    count = int(seconds * rate)
    with BagWriter(path) as bag:
        conn = bag.add_connection("/load", connection_header(cls))
        for number in range(count):
            offset = int(number * 1e9 / rate)
            bag.write(conn, 1_700_000_000_000_000_000 + offset, cls._encode(cls(offset / 1e9)))
    return count


def play(command: list[str], env: dict[str, str], bag: Path, count: int) -> dict[str, float]:
    """Play a bag; return how far, in ms, messages came from their times, beside the offset that most have."""
    with role("listen", "/load", count, env=env) as ear:
        assert ear.stdout is not None
        ear.stdout.readline()
        subprocess.run(
            [*command, "-d", "1", "--queue", "20000", str(bag)],  # stock's queue of 100 overflows at 20 kHz
            env=env, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=DEADLINE,
        )  # fmt: skip
        lines = ear.communicate(timeout=DEADLINE)[0].split("\n")
    came = [(float(moment), float(value)) for moment, value in (line.split() for line in lines if line)]
    assert len(came) == count, f"only {len(came)} of {count} messages came"
    offsets = sorted(moment - value for moment, value in came)
    typical = offsets[len(offsets) // 2]
    errors = sorted(abs(offset - typical) * 1e3 for offset in offsets)
    return {MEDIAN: errors[count // 2], P99: errors[int(count * 0.99)], WORST: errors[-1]}


def measure(side: str, work: str, seconds: float, env: dict[str, str], folder: Path) -> dict[str, float]:
    """Return the figures of a work.

    Args:
        side: ``ours``, ``stock``, or for reading ``rosbags``.
        work: one of WORKS.
        seconds: how long to record, or to play.
        env: environment variables.
        folder: for the bags.
    """
    if work in LOADS:
        return record(COMMANDS[side]["record"], env, folder / f"{side}.bag", *LOADS[work], seconds)
    if work in READ:
        return {READING: reading_rate(side, READ[work], env, folder)}
    if work == INFO:
        return {TIME: info_time(side, env, folder)}
    count = make_regular_bag(folder / "regular.bag", seconds, PLAYS[work])
    return play(COMMANDS[side]["play"], env, folder / "regular.bag", count)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Recording, playing and reading, beside stock's.")
    parser.add_argument("--side", choices=SIDES, help="print the figures of one side as JSON")
    parser.add_argument("--work", choices=WORKS, help="what to measure; all without it")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long to record or play (5)")
    parser.add_argument("--only", default="", metavar="WORDS", help="only works with this in their names")
    parser.add_argument("--role", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    sys.path.insert(0, str(SOURCE))
    if options.role:
        name, topic, *numbers = options.role
        if name == "publish":
            publish(topic, float(numbers[0]), int(numbers[1]), float(numbers[2]))
        else:
            listen(topic, int(numbers[0]))
        return 0
    if options.side in (None, "stock") and not Path(COMMANDS["stock"]["record"][0]).exists():
        print("stock rosbag is not installed; run interop/setup", file=sys.stderr)
        return 3
    works = [work for work in WORKS if work == (options.work or work) and options.only in work]
    with tempfile.TemporaryDirectory() as name, system(Path(name)) as env:
        if not options.side:
            return table(works, options.seconds, env, Path(name))
        figures = {}
        for work in works:
            found = measure(options.side, work, options.seconds, env, Path(name))
            figures.update({f"{work}: {what}": figure for what, figure in found.items()})
        print(json.dumps(figures))
        return 0


def table(works: list[str], seconds: float, env: dict[str, str], folder: Path) -> int:
    """Print the figures of both sides; return the exit code."""
    failed = False
    print(f"{'':36} {'pyros1':>10} {'stock':>10}")
    for work in works:
        ours, stock = (measure(side, work, seconds, env, folder) for side in COMMANDS)
        for what, unit in UNITS.items():
            if what in ours:
                print(f"{work + ': ' + what:36} {ours[what]:10.3f} {stock[what]:10.3f} {unit}", flush=True)
        failed = failed or (stock.get(KEPT) == 100 and ours[KEPT] < 100)
        failed = failed or (PLAYS.get(work) == 1e3 and ours[P99] >= 1.0)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
