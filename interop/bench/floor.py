"""How close a round trip comes to the fastest that is possible: two Python processes with a bare Unix socket.

::

    python interop/bench/floor.py [--runs N] [--seconds S] [--under CONDITIONS]

Both do the same work in turns: one thread sends every 0.5 ms, another one receives the answer; the other process
answers. For ours, over TCP and over the local transport, a message is encoded and decoded each way, and callbacks run.
"""

from __future__ import annotations

import argparse
import json
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from statistics import median

HERE = Path(__file__).resolve().parent
sys.path.insert(1, str(HERE.parent / "peers"))
sys.path.insert(2, str(HERE.parents[1] / "src"))

from conditions import CONDITIONS  # noqa: E402  found through the path above
from harness import STOCK_PYTHON, Master, free_port  # noqa: E402
from model import OURS  # noqa: E402
from steps import LOCAL, Bench, Program, Together  # noqa: E402

BARE = "bare socket"
ROUND_TRIPS = {"over TCP": "queue=1000", "over the local transport": f"queue=1000 {LOCAL}"}
MESSAGE = bytes(12)  # as a Float64 takes with its length


def bare(seconds: float) -> dict[str, float]:
    """Measure round trips over a bare socket; return their median and 99th percentile in microseconds."""
    here, there = socket.socketpair()
    if os.fork() == 0:
        here.close()
        while data := there.recv(1 << 16):
            there.send(data)
        os._exit(0)
    there.close()
    received, times = threading.Event(), []
    received_at = 0.0

    def receive() -> None:
        nonlocal received_at
        while here.recv(1 << 16):
            received_at = time.perf_counter()
            received.set()

    receiver = threading.Thread(target=receive)
    receiver.start()
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        received.clear()
        sent_at = time.perf_counter()
        here.send(MESSAGE)
        received.wait(1)
        times.append((received_at - sent_at) * 1e6)
        time.sleep(0.0005)
    here.shutdown(socket.SHUT_RDWR)
    receiver.join()
    os.wait()
    times.sort()
    return {"p50": times[len(times) // 2], "p99": times[len(times) * 99 // 100]}


def main() -> int:
    """Measure in turns and print a table for each condition."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--under", default="quiet,busy", help=f"some of {','.join(CONDITIONS)}")
    parser.add_argument("--bare", action="store_true", help="only measure the bare socket, once")
    options = parser.parse_args()
    if options.bare:
        print(json.dumps(bare(options.seconds)))
        return 0
    with tempfile.TemporaryDirectory() as home:
        master = Master("stock", Path(home) / "ros", free_port())
        try:
            master.start()
            bench = Bench(master, Path(home) / "import", options.seconds)
            for condition in options.under.split(","):
                report(condition, bench, options.runs)
        finally:
            master.close()
    return 0


def report(condition: str, bench: Bench, runs: int) -> None:
    found: dict[str, list[dict[str, float]]] = {name: [] for name in (BARE, *ROUND_TRIPS)}
    for _ in range(runs):
        with CONDITIONS[condition]():
            command = [STOCK_PYTHON, __file__, "--bare", "--seconds", str(bench.seconds)]
            found[BARE].append(json.loads(subprocess.check_output(command)))
            for name, words in ROUND_TRIPS.items():
                programs = (Program(OURS, "echo", words), Program(OURS, "ping", words))
                found[name].append(Together(programs).run(bench))
    print(f"{condition}: round trip in microseconds, medians of {runs} runs, and times the bare socket's")
    for name, results in found.items():
        cells = []
        for share in ("p50", "p99"):
            ours, floor = (median(run[share] for run in runs) for runs in (results, found[BARE]))
            cells.append(f"{ours:7.0f} ({ours / floor:.2f})")
        print(f"    {name:26} median {cells[0]}   99 % {cells[1]}")


if __name__ == "__main__":
    sys.exit(main())
