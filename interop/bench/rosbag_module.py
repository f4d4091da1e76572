"""Writing and reading bags from programs: stock's module rosbag, ours, and pyros1.bag.

::

    python interop/bench/rosbag_module.py           # all, taking turns; the best of three, as a table
    python interop/bench/rosbag_module.py SIDE TYPE BAG     # the messages in a second that one writes and reads

Exit code: 0; 1 if our module reads or writes fewer messages than stock's, or reads more than 10 % fewer than
pyros1.bag. Needs a quiet machine.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path
from typing import Any

SOURCE = Path(__file__).resolve().parents[2] / "src"
START = SOURCE / "pyros1" / "drop_in" / "start"
SIDES = ("stock", "ours", "pyros1.bag")
TYPES = ("std_msgs/Float64", "sensor_msgs/Imu")
MESSAGES = 30_000
ROUNDS = 3


def measure(side: str, kind: str, path: str) -> tuple[float, float]:
    """Return the messages in a second that are written, and read."""
    package, name = kind.split("/")
    bags: Any
    if side == "pyros1.bag":
        bags = import_module("pyros1.bag")
        cls = getattr(import_module(f"pyros1.msgs.{package}.msg"), name)
        make, stamp_of = bags.open, import_module("pyros1").Time
    else:
        bags = import_module("rosbag")
        cls = getattr(import_module(f"{package}.msg"), name)
        make, stamp_of = bags.Bag, import_module("genpy").Time
    messages = [cls() for _ in range(MESSAGES)]
    stamps = [stamp_of(1000 + number // 1000, number % 1000 * 10**6) for number in range(MESSAGES)]
    began = time.perf_counter()
    with make(path, "w") as bag:
        for message, stamp in zip(messages, stamps):  # noqa: B905  as users write it
            bag.write("/topic", message, stamp)
    wrote = time.perf_counter()
    with make(path) as bag:
        count = sum(1 for _ in (bag.messages() if side == "pyros1.bag" else bag.read_messages()))
    assert count == MESSAGES
    return MESSAGES / (wrote - began), MESSAGES / (time.perf_counter() - wrote)


def ask(side: str, kind: str, path: Path) -> tuple[float, float]:
    """Measure in a process of its own."""
    env = {**os.environ, "PYTHONPATH": f"{START}{os.pathsep}{SOURCE}"}
    if side == "stock":
        del env["PYTHONPATH"]
    python = "/usr/bin/python3" if side == "stock" else sys.executable
    done = subprocess.run(
        [python, __file__, side, kind, str(path)], env=env, check=True, capture_output=True, text=True, timeout=120
    )
    written, read = done.stdout.split()[-2:]
    return float(written), float(read)


def main() -> int:
    """Measure and print; return the exit code."""
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        print(f"{'messages in a second':28}" + "".join(f"{side:>12}" for side in SIDES))
        for kind in TYPES:
            results: dict[str, list[tuple[float, float]]] = {side: [] for side in SIDES}
            for _ in range(ROUNDS):
                for side in SIDES:
                    results[side].append(ask(side, kind, Path(folder) / "x.bag"))
            best = {side: [max(column) for column in zip(*rows, strict=True)] for side, rows in results.items()}
            for number, work in enumerate(("write", "read")):
                print(f"{work + ' ' + kind:28}" + "".join(f"{best[side][number]:12.0f}" for side in SIDES))
                failed = failed or best["ours"][number] < best["stock"][number]
            failed = failed or best["ours"][1] < 0.9 * best["pyros1.bag"][1]
    return int(failed)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(*measure(*sys.argv[1:4]))
    else:
        sys.exit(main())
