"""pyros1 tf beside stock's tf_echo, tf_monitor, view_frames, tf_remap and static publishers, on the same frames.

Feature: tf tools -- `pyros1 tf echo, monitor, tree, view_frames, static_transform_publisher, remap`
"""

from __future__ import annotations

import itertools
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from shlex import split
from typing import Any

import pytest
from harness import STOCK_PYTHON, Master, Process, until

from pyros1.node import Node
from pyros1.tf import Buffer, TransformListener

OWN_MASTER = True
MASTERS = ("ours",)  # stock's tool and ours are compared, whatever the master

TF, TF2, TF2_TOOLS = Path("/usr/lib/tf"), Path("/usr/lib/tf2_ros"), Path("/usr/lib/tf2_tools")
Start = Callable[..., Process]

pytestmark = [
    pytest.mark.ours_only,
    pytest.mark.skipif(not (TF2_TOOLS / "echo.py").exists(), reason="tf2-tools is not installed; run interop/setup"),
]


def ours(*words: str) -> list[str]:
    return [sys.executable, "-m", "pyros1", "tf", *words]


def stock(path: Path, *words: str) -> list[str]:
    """A stock tool; those in Python by the stock interpreter, and output line by line."""
    python = path.suffix == ".py" or b"python" in path.read_bytes()[:40]
    return [*([STOCK_PYTHON, "-u"] if python else ["stdbuf", "-oL"]), str(path), *words]


@pytest.fixture
def start(launcher: Master) -> Start:
    def run(command: list[str], **extra: str) -> Process:
        return launcher.run(command, python="ours" if command[0] == sys.executable else "stock", **extra)

    return run


@pytest.fixture
def listener(launcher: Master) -> Iterator[Buffer]:
    """A buffer of ours under this master."""
    node = Node("tf_test", anonymous=True, argv=[], environ=launcher.environ(), handle_signals=False)
    buffer = Buffer()
    TransformListener(node, buffer)
    yield buffer
    node.shutdown()


@pytest.fixture
def frames(start: Start, listener: Buffer) -> str:
    """map -> odom from ours, static; odom -> base from stock, 20 Hz; base -> lidar from stock, static."""
    start(ours("static_transform_publisher", "1", "2", "3", "0.1", "0.2", "0.3", "map", "odom", "__name:=tf_one"))
    start(stock(TF / "static_transform_publisher", *split("1 2 3 0.1 0.2 0.3 odom base 50 __name:=tf_two")))
    start(stock(TF2 / "static_transform_publisher", *split("0 0 1 0 0 0.6 0.8 base lidar __name:=tf_three")))
    assert listener.can_transform("map", "lidar", timeout=60), listener.all_frames_as_string()
    return "map"


def block(process: Process, first: str, count: int) -> list[str]:
    """The first line of a kind and the lines behind it."""
    process.wait_line(first)
    place = next(number for number, line in enumerate(process.lines) if re.search(first, line))
    until(lambda: len(process.lines) >= place + count, f"{count} lines after {first}")
    return process.lines[place : place + count]


def timeless(lines: list[str]) -> list[str]:
    """Lines with # in place of times."""
    return [re.sub(r"\d{10}\.\d+", "#", line) for line in lines]


# Echo -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("source", "target", "more"),
    [("map", "base", []), ("lidar", "map", []), ("map", "odom", ["_precision:=7"]), ("map", "lidar", ["20"])],
)
def test_echo(frames: str, start: Start, source: str, target: str, more: list[str]) -> None:
    """L195: the same lines, but for the time."""
    mine, other = (
        block(start(command), "^At time", 10)
        for command in (ours("echo", source, target, *more), stock(TF / "tf_echo", source, target, *more))
    )
    assert timeless(mine) == timeless(other)


def test_echo_with_precision_says_so(frames: str, start: Start) -> None:
    for command in (
        ours("echo", "map", "odom", "_precision:=2"),
        stock(TF / "tf_echo", "map", "odom", "_precision:=2"),
    ):
        start(command).wait_line("^Precision default value was overriden, new value: 2$")


def test_echo_fails(frames: str, start: Start) -> None:
    """The same but for the order in which the frames became known."""
    mine, other = (
        block(start(command), "^Failure at", 7)
        for command in (ours("echo", "map", "x"), stock(TF / "tf_echo", "map", "x"))
    )
    assert timeless(mine)[:3] == timeless(other)[:3]
    assert sorted(mine[3:]) == sorted(other[3:])


@pytest.mark.parametrize("more", [[], ["-r", "5", "-l", "3", "-p", "1"], ["-o", "-0.3", "-l", "9", "-r", "5"]])
def test_echo_of_tf2_tools(frames: str, start: Start, more: list[str]) -> None:
    """L198: through the package's script."""
    script = Path(__file__).parents[2] / "src/pyros1/packages/tf2_tools/scripts/echo.py"
    mine, other = (
        block(start(command), "^At time", 10)
        for command in (
            [sys.executable, str(script), "map", "base", *more],
            stock(TF2_TOOLS / "echo.py", "map", "base", *more),
        )
    )
    assert timeless(mine) == timeless(other)


def test_wrong_arguments_end_with_the_same_code(launcher: Master) -> None:
    cases: list[tuple[list[str], list[str]]] = [
        (ours("echo"), [str(TF / "tf_echo")]),
        (ours("echo", "a"), [str(TF / "tf_echo"), "a"]),
        (ours("static_transform_publisher", "--tf", "1"), [str(TF / "static_transform_publisher"), "1"]),
        (ours("static_transform_publisher", "--tf2", "1", "2"), [str(TF2 / "static_transform_publisher"), "1", "2"]),
        (ours("static_transform_publisher", "/nope"), [str(TF2 / "static_transform_publisher"), "/nope"]),
        (
            ours("static_transform_publisher", *split("0 0 0 0 0 0 a a")),
            [str(TF2 / "static_transform_publisher"), *split("0 0 0 0 0 0 a a")],
        ),
    ]
    for mine, other in cases:
        codes = [
            subprocess.run(
                command,
                env=launcher.environ(python),
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=30,
                check=False,
            ).returncode
            for command, python in ((mine, "ours"), (other, "stock"))
        ]
        assert codes[0] == codes[1], mine


# Monitor and pictures -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("chain", [[], ["map", "lidar"]])
def test_monitor(frames: str, start: Start, chain: list[str]) -> None:
    """L196: the same lines but for the figures; ours knows who publishes."""

    def shape(lines: list[str]) -> list[str]:
        text = re.sub(r"-?\d+(\.\d+)?(e[-+]\d+)?", "#", "\n".join(lines))
        return re.sub(r"/tf_(one|two|three)", "unknown_publisher", text).split("\n")

    def report(process: Process) -> list[str]:
        def whole() -> list[str] | None:
            """A report in which all three frames are."""
            starts = [number for number, line in enumerate(process.lines) if line.startswith("RESULTS")]
            for first, last in itertools.pairwise(starts):
                lines = [line for line in process.lines[first:last] if line]
                if sum(line.startswith("Frame: ") for line in lines) == 3:
                    return lines
            return None

        found: list[str] = until(whole, "a whole report")
        return found

    mine, other = report(start(ours("monitor", *chain))), report(start(stock(TF / "tf_monitor", *chain)))
    nodes = [line for line in mine if line.startswith("Node: ")]
    assert len(nodes) == 3
    assert shape([line for line in mine if line not in nodes]) == shape(
        [x for x in other if not x.startswith("Node: ")]
    )
    assert set(shape(nodes)) == set(shape([line for line in other if line.startswith("Node: ")]))
    rate = next(float(line.split()[2]) for line in nodes if "tf_two" in line)
    assert 1 < rate < 100, "20 Hz, more in the first moments"


def edges(file: Path) -> dict[str, Any]:
    """parent -> child, with the label's words and the broadcaster."""
    found = {}
    for line in file.read_text().splitlines():
        match = re.fullmatch(r'"(.*)" -> "(.*)"\[label="(.*)"\];', line)
        if match:
            rows = match[3].split("\\n")
            found[match[1], match[2]] = [re.sub(r": [-\d.]+$", ": #", row) for row in rows]
    return found


def test_view_frames(frames: str, launcher: Master, tmp_path: Path) -> None:
    """L198: the same graph as tf2_tools', and Graphviz takes it."""
    for name, command, python in (
        ("ours", ours("view_frames", "-t", "2"), "ours"),
        ("stock", stock(TF2_TOOLS / "view_frames.py"), "stock"),
    ):
        (tmp_path / name).mkdir()
        done = subprocess.run(
            command, env=launcher.environ(python), cwd=tmp_path / name, capture_output=True, timeout=60, check=False
        )
        assert done.returncode == 0, done.stderr
        assert (tmp_path / name / "frames.pdf").read_bytes()[:5] == b"%PDF-"
    mine, other = edges(tmp_path / "ours/frames.gv"), edges(tmp_path / "stock/frames.gv")
    assert mine == other and set(mine) == {("map", "odom"), ("odom", "base"), ("base", "lidar")}


def test_view_frames_of_a_node(frames: str, start: Start, launcher: Master, tmp_path: Path) -> None:
    """Stock's asks our listener and ours stock's (tf2_echo.py has none: its buffer tells ~tf2_frames)."""
    start(stock(TF2_TOOLS / "echo.py", "map", "base", "__name:=tf_asked"))
    until(lambda: launcher.call("lookupService", "/tf_asked/tf2_frames")[0] == 1, "stock's service")

    def asked() -> bool:
        done = subprocess.run(
            ours("view_frames", "--node", "/tf_asked", "-o", str(tmp_path / "a.svg")),
            env=launcher.environ("ours"),
            capture_output=True,
            timeout=30,
            check=False,
        )
        return b"lidar" in done.stdout

    until(asked, "ours asks stock")


# Publishing -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        "1 -2.5 3 0.1 -0.2 3 a b",
        "1 -2.5 3 0.18257418583505536 0.3651483716701107 0.5477225575051661 0.7302967433402214 a b",
        "1 -2.5 3 0.1 -0.2 3 a b 50",
        "1 -2.5 3 0 0 3 4 a b 50",
    ],
)
def test_static_publishers_send_the_same(launcher: Master, start: Start, words: str) -> None:
    """L197: to a stock listener."""
    package = TF if words.endswith("50") else TF2
    heard = []
    for number, command in enumerate(
        (
            ours("static_transform_publisher", *words.split()),
            stock(package / "static_transform_publisher", *words.split()),
        )
    ):
        topic = f"/tf_same{number}"
        start([*command, f"/tf:={topic}", f"/tf_static:={topic}"])
        text = launcher.tool("rostopic", "echo", "-n", "1", topic)
        text = re.sub(r"WARNING: topic \[\S+\] does not appear to be published yet\n", "", text)  # it began first
        heard.append(re.sub(r"(n?secs): +\d+", r"\1: #", text))
    first, second = (re.sub(r"-?\d+\.\d+(e-\d+)?", lambda m: f"{float(m[0]):.9f}", text) for text in heard)
    assert first.replace("-0.000000000", "0.000000000") == second.replace("-0.000000000", "0.000000000")


def test_stock_hears_our_static_transforms_when_it_comes_later(frames: str, start: Start) -> None:
    echo = start(stock(TF / "tf_echo", "map", "odom"))
    echo.wait_line(r"^- Translation: \[1\.000, 2\.000, 3\.000\]$")


def test_remap(start: Start, launcher: Master) -> None:
    """L199: both rename the same, in the same transforms."""
    mappings = "_mappings:=[{old: a, new: x/a}, {old: c, new: d}, {old: q}]"
    heard = []
    for number, command in enumerate((ours("remap", mappings), stock(TF / "tf_remap", mappings))):
        start([*command, f"/tf_old:=/tf_in{number}", f"/tf:=/tf_out{number}", f"__name:=tf_remap{number}"])
        for parent, child in ("ab", "bc"):
            start(
                stock(
                    TF / "static_transform_publisher", *f"1 2 3 0 0 0 {parent} {child} 20 /tf:=/tf_in{number}".split()
                )
            )
        frames: set[tuple[str, str]] = set()

        def hear(topic: str = f"/tf_out{number}", found: set[tuple[str, str]] = frames) -> bool:
            text = launcher.tool("rostopic", "echo", "-n", "4", topic)
            found |= set(
                zip(re.findall(r' frame_id: "(.*)"', text), re.findall(r'child_frame_id: "(.*)"', text), strict=True)
            )
            return len(found) == 2

        until(hear, "both transforms")
        heard.append(frames)
    assert heard[0] == heard[1] == {("x/a", "b"), ("b", "d")}
