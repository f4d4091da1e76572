"""What `pyros1 web` costs under load: CPU and memory of the server, what it sends, and frames per second and memory of
the page.

::

    python interop/bench/web.py [--seconds 10] [--under CONDITION]

Needs pyros1[test] and Debian's chromium and chromium-driver. The page is drawn without a graphics card, so a
machine with one shows more frames. The condition (see `conditions`) is that of the server and the robot's nodes; the
browser runs outside it, as on another machine.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "peers"))

from browsing import Browser, start_chromium
from conditions import CONDITIONS, QUIET

from pyros1.master.server import Master
from pyros1.msgs import load_message
from pyros1.web.links import layout_link

COUNT_FRAMES = """
    window.frames_seen = 0;
    const count = () => { window.frames_seen += 1; requestAnimationFrame(count); };
    if (!window.counting) { window.counting = true; requestAnimationFrame(count); }
"""
COUNT_UPDATES = """
    window.updates_seen = 0;
    window.WebSocket = class extends WebSocket {
        constructor(...words) {
            super(...words);
            this.addEventListener("message", () => { window.updates_seen += 1; });
        }
    };
"""
CONSOLE = {"panel": "console"}
PLOT = {"panel": "plot", "settings": {"curves": [f"/wave{number}/data" for number in range(20)]}}
IMAGE = {"panel": "image", "settings": {"topic": "/camera"}}
SCENE = {"panel": "scene", "settings": {"fixed": "map", "topics": ["/cloud"]}}
ALL = [{"split": "column", "sizes": [1, 1], "parts": two} for two in ([CONSOLE, PLOT], [IMAGE, SCENE])]
LOADS: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "nothing": ((), CONSOLE),
    "10,000 log messages per second": (("log",), CONSOLE),
    "20 curves of 1 kHz": (("waves",), PLOT),
    "one image of 640 x 480, 30 Hz": (("image",), IMAGE),
    "a cloud of a million points, 10 Hz": (("cloud",), SCENE),
    "all of them at once, on one page": (
        ("log", "waves", "image", "cloud"),
        {"split": "row", "sizes": [1, 1], "parts": ALL},
    ),
}


def log(node: Any, steps: Iterator[float]) -> None:
    publisher = node.advertise("/rosout", "rosgraph_msgs/Log")
    message = publisher.type(name="/flood", level=2, file="flood.py", function="main")
    for step, _ in enumerate(steps):  # 100 steps per second
        for number in range(100):
            message.msg = f"message {step * 100 + number} of a flood"
            publisher.publish(message)


def waves(node: Any, steps: Iterator[float]) -> None:
    import math

    publishers = [node.advertise(f"/wave{number}", "std_msgs/Float64") for number in range(20)]
    for moment in steps:  # 1000 steps per second
        for number, publisher in enumerate(publishers):
            publisher.publish(math.sin(moment * (number + 1) / 3) + number)


def image(node: Any, steps: Iterator[float]) -> None:
    publisher = node.advertise("/camera", "sensor_msgs/Image", queue_size=1)
    pictures = [bytes([shade]) * (640 * 480 * 3) for shade in range(0, 250, 10)]
    message = publisher.type(width=640, height=480, encoding="rgb8", step=1920)
    for number, _ in enumerate(steps):
        message.data = pictures[number % len(pictures)]
        publisher.publish(message)


def cloud(node: Any, steps: Iterator[float]) -> None:
    import numpy as np

    points = np.random.default_rng(1).uniform(-5, 5, (1_000_000, 3)).astype("<f4")
    publisher = node.advertise("/cloud", "sensor_msgs/PointCloud2", queue_size=1)
    fields = [{"name": name, "offset": 4 * number, "datatype": 7, "count": 1} for number, name in enumerate("xyz")]
    message = publisher.type(height=1, width=len(points), point_step=12, row_step=12 * len(points), fields=[])
    field = load_message("sensor_msgs/PointField")
    message.fields = [field(**each) for each in fields]
    message.header.frame_id = "map"
    data = [(points + shift).tobytes() for shift in (0.0, 0.1)]
    for number, _ in enumerate(steps):
        message.data = data[number % 2]
        publisher.publish(message)


RATES = {"log": 100, "waves": 1000, "image": 30, "cloud": 10}


def load(kind: str) -> None:
    """Publish until the process is ended."""
    import pyros1

    with pyros1.Node("load", anonymous=True) as node:

        def steps() -> Iterator[float]:
            start, number = time.monotonic(), 0
            while node.ok():
                number += 1
                time.sleep(max(0.0, start + number / RATES[kind] - time.monotonic()))
                yield number / RATES[kind]

        {"log": log, "waves": waves, "image": image, "cloud": cloud}[kind](node, steps())


def cpu(pid: int) -> float:
    """Return the seconds of CPU time that a process has used."""
    return time.clock_gettime(~pid << 3 | 2)  # as clock_getcpuclockid(3) does


def memory(pid: int) -> float:
    """Return a process's resident memory in MB."""
    match = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{pid}/status").read_text())
    assert match
    return int(match[1]) / 1000


@contextmanager
def program(*words: str, **options: Any) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen([sys.executable, *words], stdin=subprocess.DEVNULL, text=True, **options)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(20)


def measure(browser: Browser, server: int, seconds: float) -> tuple[float, float, float, float, float]:
    """Return CPU of the server in percent of a core, its memory in MB, updates and frames per second, and memory of the
    page in MB.
    """
    browser.run(f"{COUNT_FRAMES}; window.updates_seen = 0")
    before, since = cpu(server), time.monotonic()
    time.sleep(seconds)
    took = time.monotonic() - since
    frames, updates = browser.run("return [window.frames_seen, window.updates_seen]")
    heap = browser.run("return performance.memory ? performance.memory.usedJSHeapSize / 1e6 : 0")
    return 100 * (cpu(server) - before) / took, memory(server), updates / took, frames / took, heap


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each measurement")
    parser.add_argument("--under", choices=CONDITIONS, default=QUIET, help="condition of the server and the nodes")
    parser.add_argument("--load", choices=RATES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.load:
        load(options.load)
        return
    master = Master(port=0, bind_host="127.0.0.1")
    master.start()
    folder = tempfile.mkdtemp()
    environ = {**os.environ, "ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": folder}
    print(f"{'load':36} {'server CPU':>11} {'memory':>9} {'updates':>10} {'frames':>9} {'page':>9}")
    try:
        with (
            start_chromium() as driver,
            CONDITIONS[options.under](),
            program("-m", "pyros1", "web", "--port", "0", env=environ, stdout=subprocess.PIPE) as server,
        ):
            driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": COUNT_UPDATES})
            assert server.stdout is not None
            link = server.stdout.readline().split()[-1]
            browser = Browser(driver)
            for name, (kinds, tree) in LOADS.items():
                browser.open(layout_link(link, "load", tree))
                with ExitStack() as programs:
                    for kind in kinds:
                        words = (__file__, "--load", kind)
                        programs.enter_context(program(*words, env=environ, stdout=subprocess.DEVNULL))
                    time.sleep(5.0 if kinds else 0.0)  # until all is connected, and the page has something to show
                    figures = measure(browser, server.pid, options.seconds)
                used, size, updates, frames, heap = figures
                numbers = f"{used:9.0f} % {size:6.0f} MB {updates:7.0f} /s {frames:6.0f} /s {heap:6.0f} MB"
                print(f"{name:36} {numbers}", flush=True)
    finally:
        master.stop()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
