"""How soon a killed master is back: `python interop/restarting.py [--nodes N] [--times T]`.

A core of pyros1 has some nodes of roscpp, each of which publishes a topic. It is killed, and started again at once.
Shown are the seconds from the start of the new process until it answers a call, the processor time that it has used
until then (what it takes on a machine that is idle), and the seconds until it says that it has found its nodes; then
what `python -c pass` takes, with which the machine's speed can be compared.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "peers"))

from harness import Master, free_port, missing_stock
from vitals import cpu_clock


def restart(master: Master, nodes: int) -> tuple[float, float, float]:
    """Kill a master, and start it again.

    Returns:
        The seconds until it answers, the processor time that it has used until then, and the seconds until it has found
        its nodes.
    """
    core = master.core.pop()
    os.kill(core.pid, 9)
    core.wait(10)
    core.close()
    begin = time.monotonic()
    master.core.append(
        master.run([sys.executable, "-m", "pyros1", "core", "-p", str(master.port)], python="ours", label="core")
    )
    while True:
        try:
            master.call("getPid")
            break
        except OSError:
            time.sleep(0.001)
    answers = time.monotonic() - begin
    used = cpu_clock(master.core[0].pid)
    if nodes:
        master.core[0].wait_line(f"resumed with {nodes} nodes", 60)
    return answers, used, time.monotonic() - begin


def main() -> int:
    """Measure, and show it; return the exit code."""
    parser = argparse.ArgumentParser(description="Measure how soon a killed master is back.")
    parser.add_argument("--nodes", type=int, default=5)
    parser.add_argument("--times", type=int, default=5)
    options = parser.parse_args()
    if reason := missing_stock():
        print(reason)
        return 3
    with tempfile.TemporaryDirectory() as folder:
        master = Master("ours", Path(folder), free_port())
        try:
            master.start()
            for number in range(options.nodes):
                node = master.ready_peer("roscpp", f"node{number}")
                node.advertise(f"/t{number}", "std_msgs/String")
            for _ in range(options.times):
                time.sleep(1.0)  # the journal has what there is
                answers, used, found = restart(master, options.nodes)
                begin = time.monotonic()
                subprocess.run([sys.executable, "-c", "pass"], check=True)
                bare = time.monotonic() - begin
                load = os.getloadavg()[0]
                print(
                    f"answers after {answers:.2f} s ({used:.2f} s of processor), all nodes found after {found:.2f} s, "
                    f"a bare Python takes {bare:.3f} s, load {load:.1f}",
                    flush=True,
                )
        finally:
            master.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
