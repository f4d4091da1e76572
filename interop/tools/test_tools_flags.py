"""Flags of the commands that no other file compares: every option of stock's is known; those of what goes on until it
is stopped (L45-L66), of publishing (L56-L59, L67), of the recorder (L107-L111); rosrun (L22-L24) and rosmaster (L20).
"""

from __future__ import annotations

import queue
import re
import signal
import subprocess
import xmlrpc.client
from collections import defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from harness import Master, Process, free_port, our_tools, stock_tools, until
from named_tools import named_tool

import pyros1
from pyros1.bag.format.reader import BagReader
from pyros1.msgs import load_message

MASTERS = ("ours",)  # stock's tools and ours are compared, whatever the master

pytestmark = pytest.mark.ours_only

_MESSAGES = "show list md5 package packages"
HELP = {
    "roscore": "",
    "rosmaster": "",
    "roslaunch": "",
    "rostest": "",
    "roswtf": "",
    "rosversion": "",
    "catkin_create_pkg": "",
    "rostopic": "list info type find echo hz bw delay pub",
    "rosnode": "list info ping machine kill cleanup",
    "rosservice": "list info type uri node args find call",
    "rosparam": "list get set load dump delete",
    "rosmsg": _MESSAGES,
    "rossrv": _MESSAGES,
    "rosmsg-proto": "msg srv",
    "rosclean": "check purge",
    "rosbag": "record play info check fix filter compress decompress reindex encrypt decrypt",
    "/usr/lib/dynamic_reconfigure/dynparam": "get set set_from_parameters load dump",
}


@pytest.mark.parametrize("name", HELP)
def test_every_option_of_stock_is_known(tmp_path: Path, name: str) -> None:
    """The options in stock's help are in ours, each verb's."""
    ours = named_tool(tmp_path, Path(name).name)

    def options(tools: Any, program: str, verb: str) -> set[str]:
        code, out, err = tools.ask([program, *verb.split(), "-h"], {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)})
        assert code == 0, f"{program} {verb}: {err}"
        return set(re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*", out + err))

    for verb in HELP[name].split() or [""]:
        missing = options(stock_tools(), name, verb) - options(our_tools(), ours, verb)
        assert not missing, f"{name} {verb}"


# What goes on ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def node(master: Master) -> Iterator[pyros1.Node]:
    """A node that publishes two topics fifty times a second."""
    text, stamped = load_message("std_msgs/String"), load_message("geometry_msgs/PointStamped")
    with pyros1.Node("live", argv=[], environ=master.environ(), rosout=False, handle_signals=False) as node:
        texts, points = node.advertise("/live/text", text), node.advertise("/live/stamped", stamped)

        def beat(event: object) -> None:
            texts.publish(text("word"))
            point: Any = stamped()
            point.header.stamp = node.now()
            points.publish(point)

        node.timer(0.02, beat)
        yield node


Start = Callable[..., dict[str, Process]]


@pytest.fixture
def start(launcher: Master, tmp_path: Path) -> Iterator[Start]:
    """Starts the same command line of both."""
    ours = named_tool(tmp_path, "rostopic")

    running: list[Process] = []

    def both(words: list[str], *more: list[str]) -> dict[str, Process]:
        stock = launcher.run(["/usr/bin/rostopic", *words])
        mine = launcher.run([ours, *(more[0] if more else words)], python="ours")
        running.extend([stock, mine])
        return {"stock": stock, "ours": mine}

    yield both
    for process in running:  # all at once
        if process.child.poll() is None:
            process.signal(signal.SIGINT)


LIVE = {
    "hz -w 5 /live/text": r"window: [56]$",
    "hz --filter False /live/text": "no new messages",
    "hz --filter m.data=='word' --wall-time --tcpnodelay /live/text": "std dev",
    "hz /live/text /live/stamped": "^/live/stamped",
    "bw -w 5 /live/text": "window: 5$",
    "delay -w 5 --tcpnodelay /live/stamped": r"window: [56]$",
    "delay /live/text": "msg does not have header",
    "echo --offset -n 1 /live/stamped": "^---",
}


def test_live_flags(launcher: Master, node: pyros1.Node, start: Start) -> None:
    """The same lines but for their numbers; sizes of windows and of messages count."""
    running = {line: start(line.split()) for line in LIVE}
    for line, wanted in LIVE.items():
        shapes = {}
        for who, process in running[line].items():
            process.wait_line(wanted, 30)
            at = next(number for number, text in enumerate(process.lines) if re.search(wanted, text))
            first = (
                at - 1
                if "average" in process.lines[at - 1]
                else process.lines.index("header: ")
                if "echo" in line
                else at
            )
            shapes[who] = [shape(text, "-w 5" in line) for text in process.lines[first : at + 1]]
        if "msg does not" not in wanted:  # an error's time and place are of no interest
            assert shapes["ours"] == shapes["stock"], line
    names = set(launcher.subscribers("/live/text"))
    assert len(names) > len(LIVE) and all(re.fullmatch(r"/rostopic_\d+_\d{13}", name) for name in names), names


def shape(line: str, window: bool) -> str:
    """A line with N for each number, but for the size of a window that is full."""
    kept = re.search(r"window: .*$", line)
    text = re.sub(r" +", " ", re.sub(r"-?\b[\d.]+(?:e-?\d+)?", "N", line))
    return f"{text} {kept[0]}" if kept and window else text


# Publishing -----------------------------------------------------------------------------------------------------------

PUB = {
    "-r 20 TOPIC std_msgs/Header {stamp:\u00a0now}": 4,
    "-r 20 -s TOPIC std_msgs/Header {stamp:\u00a0now}": 4,
    "-r 20 -s --use-rostime TOPIC std_msgs/Header {stamp:\u00a0now}": 4,
    "-r 20 TOPIC std_msgs/String x": 2,
    "-r 20 -l TOPIC std_msgs/String x": 2,
    "TOPIC std_msgs/String x": 1,
    "-f FILE TOPIC std_msgs/String": 2,
    "-f FILE -l TOPIC std_msgs/String": 1,
    "-f FILE -r 20 TOPIC std_msgs/String": 2,
    "-f ONE TOPIC std_msgs/String": 4,
    "-f ONE -r 20 TOPIC std_msgs/String": 4,
    "-f ONE -r 20 -l TOPIC std_msgs/String": 4,
    "-f ONE -l TOPIC std_msgs/String": 1,
    "-f ONE -1 TOPIC std_msgs/String": 1,
    "-f ONE -r 20 TOPIC std_msgs/Empty": 4,
    "TOPIC std_msgs/String": 2,
    "-l -v TOPIC std_msgs/String": 1,
}
"""Command line -> how many messages are looked at; those without values get them on stdin."""


NUM_AT_ONCE = 3
"""How many of these lines run at a time, each by two programs: both wait only 5 s for a subscriber."""


def test_pub_flags_l53_l59(node: pyros1.Node, start: Start, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """The same messages, and stamps that go on or do not. (Whether stock's header says "latching" depends on luck.)"""
    (tmp_path / "two.yaml").write_text("data: one\n---\ndata: two\n")
    (tmp_path / "one.yaml").write_text("data: one\n")
    arrived: dict[str, queue.Queue[Any]] = defaultdict(queue.Queue)

    def begin(number: int, line: str) -> list[Process]:
        """Start both programs."""
        topics = [f"/live/{who}{number}" for who in ("stock", "ours")]
        kind = re.search(r"std_msgs/\w+", line)[0]  # type: ignore[index]  # each has one
        for topic in topics:
            request.addfinalizer(node.subscribe(topic, kind, arrived[topic].put).unregister)
        files = line.replace("FILE", str(tmp_path / "two.yaml")).replace("ONE", str(tmp_path / "one.yaml"))
        words = ["pub", *files.split(" ")]
        filled = [[word.replace("TOPIC", topic).replace("\u00a0", " ") for word in words] for topic in topics]
        processes = list(start(*filled).values())
        for process in processes:
            if words[-1] == "std_msgs/String" and "-f" not in words:
                assert process.child.stdin is not None
                process.child.stdin.write(b"data: one\n---\ndata: two\n---\n")
            if process.child.stdin is not None:
                process.child.stdin.close()
        return processes

    def collect(who: str, number: int, line: str) -> Any:
        """Return what arrived: the texts, or whether the stamps differ."""
        messages: list[Any] = []
        while len(messages) < PUB[line]:
            try:
                messages.append(arrived[f"/live/{who}{number}"].get(timeout=60))
            except queue.Empty:
                pytest.fail(f"{who}: {line}: {messages}")
        if "Header" in line:
            return len({message.stamp.to_nsec() for message in messages}) > 1
        return [getattr(message, "data", "") for message in messages]

    lines = list(enumerate(PUB))
    for first in range(0, len(lines), NUM_AT_ONCE):
        some = lines[first : first + NUM_AT_ONCE]
        processes = [process for number, line in some for process in begin(number, line)]
        for number, line in some:
            assert collect("ours", number, line) == collect("stock", number, line), line
        for process in processes:
            process.signal(signal.SIGINT)


# The recorder, rosrun, rosmaster --------------------------------------------------------------------------------------


def test_options_of_the_recorder_alone_l105_l111(launcher: Master, node: pyros1.Node, tmp_path: Path) -> None:
    """Those that only stock's binary has, and those that change nothing in the file."""
    flags = ["--topic", "/live/text", "-L", "1M", "--tcpnodelay", "-b", "0", "-l", "5"]
    ours = named_tool(tmp_path, "rosbag")
    recorders = [
        launcher.run(["/usr/lib/rosbag/record", *flags, "-O", str(tmp_path / "stock.bag")]),
        launcher.run([ours, "record", *flags, "-O", str(tmp_path / "ours.bag")], python="ours"),
    ]
    for recorder in recorders:
        assert recorder.wait(30) == 0, recorder.transcript()
    for name in ("stock", "ours"):
        with BagReader(tmp_path / f"{name}.bag") as bag:
            assert [message.connection.topic for message in bag.messages()] == ["/live/text"] * 5


RUN = [
    "",
    "--help",
    "some_pkg",
    "some_pkg hello a b:=c",
    "some_pkg scripts/hello",
    "some_pkg hello/",
    "some_pkg nope",
    "some_pkg data",
    "no_such_pkg hello",
    "--prefix echo some_pkg hello x",
    "-d some_pkg hello",
]


def test_rosrun_l22_l24(tmp_path: Path) -> None:
    scripts = tmp_path / "some_pkg" / "scripts"
    scripts.mkdir(parents=True)
    (tmp_path / "some_pkg" / "package.xml").write_text("<package><name>some_pkg</name></package>")
    (scripts / "hello").write_text('#!/bin/sh\necho hello "$@"\nexit 7\n')
    (scripts / "hello").chmod(0o755)
    (scripts / "data").write_text("")
    environ = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "ROS_PACKAGE_PATH": f"{tmp_path}:/usr/share"}
    ours = named_tool(tmp_path, "rosrun")

    def stock(line: str) -> tuple[int, str]:
        done = subprocess.run(
            ["/usr/bin/rosrun", *line.split()], env=environ, stdin=subprocess.DEVNULL, capture_output=True, check=False
        )
        return done.returncode, done.stdout.decode()

    with ThreadPoolExecutor(2) as pool:
        theirs = list(pool.map(stock, RUN))
    for line, answer in zip(RUN, theirs, strict=True):
        code, out, _ = our_tools().ask([ours, *line.split()], environ)
        if answer[0] in (0, 7) and "hello" in answer[1]:
            assert out.splitlines()[-1] == answer[1].splitlines()[-1], line
        assert code == answer[0], line


MASTER = ["--core extra", "--core --nonsense", "-h", "-w", "--core -p"]


def test_rosmaster_l20(launcher: Master, tmp_path: Path) -> None:
    """Without --core it says that roscore may be meant, and starts all the same."""
    ours = named_tool(tmp_path, "rosmaster")
    for line in MASTER:
        stock, mine = stock_tools(), our_tools()
        codes = [stock.ask(["rosmaster", *line.split()], launcher.environ())[0]]
        codes.append(mine.ask([ours, *line.split()], launcher.environ())[0])
        assert codes[1] == codes[0], line
    for program, python in (("/usr/bin/rosmaster", "stock"), (ours, "ours")):
        uri = f"http://localhost:{free_port()}"
        process = launcher.run([program, "-p", uri.rpartition(":")[2]], python=python, ROS_MASTER_URI=uri)
        process.wait_line("ACHTUNG")
        until(lambda uri=uri: answers(uri), "the master answers")
        process.signal(signal.SIGINT)
        assert process.wait() == 0, process.transcript()


def answers(uri: str) -> bool:
    try:
        with xmlrpc.client.ServerProxy(uri) as master:
            return bool(master.getPid("/flags"))
    except OSError:
        return False
