"""By hand, for a quarter of an hour: bridges, plain TCPROS and rosbridge on bad networks; see interop/bridge.md.

    sudo python interop/bridge/measure.py [WORDS OF A ROW]

On the robot, a node of stock's rospy publishes 50 small messages (Twist) and 10 images of 20 kB per second; at the
base, another one subscribes. Three ways lead from one to the other:

- bridge: a stock master and `pyros1 bridge` on each side;
- tcpros: one stock master, on the robot, so the subscriber connects to the publisher itself;
- rosbridge: `pyros1 web` on the robot, and a client of it at the base.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent
sys.path[:0] = [str(ROOT), str(ROOT.parent / "peers")]

from harness import STOCK_PYTHON, Process  # noqa: E402
from hosts import Host, Network  # noqa: E402
from sites import Message, parse  # noqa: E402
from wires import Wires  # noqa: E402

ENDS = str(ROOT / "ends.py")
RATE, IMAGE_RATE, IMAGE_SIZE = 50, 10, 20_000
SECONDS = 12.0
WARM_UP = 15.0
OUTAGE = 10.0
FRESH = 0.5
"""Seconds after which a command is stale."""
START = 90.0


class Condition(NamedTuple):
    """A network: round trip in seconds, share of lost packets, bytes per second, and seconds for which it is gone."""

    name: str
    round_trip: float
    lost: float = 0.0
    rate: float | None = None
    outage: float = 0.0


CONDITIONS = (
    *(Condition(f"{trip} ms, {lost} % lost", trip / 1000, lost / 100) for trip in (20, 100, 300) for lost in (0, 1, 5)),
    Condition("20 ms, 1 Mbit/s", 0.02, rate=125_000.0),
    Condition("20 ms, gone for 10 s", 0.02, outage=OUTAGE),
)


def start_bridge(robot: Host, base: Host) -> Process:
    """Start the bridges, and return the subscriber."""
    for host, words in (
        (base, "--site base --listen tcp/0.0.0.0:7447 --take red:**"),
        (robot, "--site red --to tcp/base:7447 --send /small /image"),
    ):
        uri = host.core("stock")
        command = host.pyros1("bridge", *words.split(), "--insecure")
        host.start(command, host.environ(uri), "bridge")
    talk(robot, f"http://{robot.name}:11311/")
    return listen(base, f"http://{base.name}:11311/", "/red")


def start_tcpros(robot: Host, base: Host) -> Process:
    """Start a master, and return the subscriber."""
    uri = robot.core("stock")
    talk(robot, uri)
    return listen(base, uri, "")


def start_rosbridge(robot: Host, base: Host) -> Process:
    """Start a server, and return its client."""
    uri = robot.core("stock")
    words = ("web", "--host", "0.0.0.0", "--port", "9090", "--token", "", "--allow", "10.88.0.0/24")
    robot.start(robot.pyros1(*words), robot.environ(uri), "server")
    talk(robot, uri)
    robot.await_port(9090)
    url = f"ws://{robot.address}:9090/"
    return base.start([sys.executable, ENDS, "rosbridge", url, ""], base.environ(), "client")


def talk(host: Host, uri: str) -> None:
    """Start the publisher."""
    command = [STOCK_PYTHON, ENDS, "talk", str(RATE), str(IMAGE_RATE), str(IMAGE_SIZE)]
    host.start(command, host.environ(uri, "stock"), "publisher").wait_line("^ready", START)


def listen(host: Host, uri: str, prefix: str) -> Process:
    """Start a subscriber."""
    return host.start([STOCK_PYTHON, ENDS, "listen", prefix], host.environ(uri, "stock"), "subscriber")


WAYS: dict[str, Callable[[Host, Host], Process]] = {
    "bridge": start_bridge,
    "tcpros": start_tcpros,
    "rosbridge": start_rosbridge,
}


def measure(condition: Condition, way: str) -> list[str]:
    """Return the cells of a row."""
    with Network() as network:
        robot, base = network.add("robot"), network.add("base")
        with Wires(robot, base) as wires:
            listener = WAYS[way](robot, base)
            listener.wait_line("^small", START)
            listener.wait_line("^image", START)
            for path in wires.both_ways(robot, base):
                path.delay, path.lost, path.rate = condition.round_trip / 2, condition.lost, condition.rate
                path.room = 64_000
            time.sleep(WARM_UP)
            start = len(listener.lines)
            if not condition.outage:
                time.sleep(SECONDS)
                return summary(parse(listener.lines[start:]))
            wires.cut(robot)
            time.sleep(condition.outage)
            start = len(listener.lines)
            wires.mend(robot)
            mended_at = time.monotonic()
            back = await_fresh(listener, start, mended_at)
            time.sleep(max(0.0, SECONDS - (time.monotonic() - mended_at)))
            return [*summary(parse(listener.lines[start:])), back]


def await_fresh(listener: Process, start: int, mended_at: float) -> str:
    """Wait for the first message that is fresh, and return how long that took, as text."""
    while time.monotonic() - mended_at < 40:
        for message in parse(listener.lines[start:]):
            if message.kind == "small" and message.age < FRESH:
                return f"{time.monotonic() - mended_at:.1f} s"
        time.sleep(0.05)
    return "not within 40 s"


def summary(messages: list[Message]) -> list[str]:
    """Return cells: commands that came fresh and stale, ages of the fresh ones and of all, images per second."""
    small = [message.age for message in messages if message.kind == "small"]
    images = [message.age for message in messages if message.kind == "image"]
    fresh = [age for age in small if age < FRESH]
    return [
        f"{len(fresh) / SECONDS:.1f}",
        str(len(small) - len(fresh)),
        f"{statistics.median(small) * 1000:.0f}" if small else "-",
        f"{sorted(small)[int(len(small) * 0.99)] * 1000:.0f}" if small else "-",
        f"{len(images) / SECONDS:.1f}",
        f"{statistics.median(images):.2f}" if images else "-",
    ]


def main() -> None:
    """Print the rows whose names contain all arguments."""
    print("| network | way | fresh /s | stale | age, median ms | 99 % ms | images /s | age s | fresh again after |")
    print("|---|---|---|---|---|---|---|---|---|")
    for condition in CONDITIONS:
        for way in WAYS:
            if all(word in f"{condition.name} {way}" for word in sys.argv[1:]):
                cells = measure(condition, way)
                print("|", " | ".join([condition.name, way, *cells, ""][:9]), "|", flush=True)


if __name__ == "__main__":
    main()
