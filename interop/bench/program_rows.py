"""The rows of whole programs: the master, commands, launches, bags; and of the code that encodes messages."""

from __future__ import annotations

import sys
from collections.abc import Iterator

from bag_steps import BagWork
from bags import CPU, INFO, KEPT, MEDIAN, MEMORY, P99, PLAYS, RATE, READ, READING, TIME
from codec import LABELS
from harness import INTEROP, STOCK_PYTHON
from launch import ALONE, DOWN, KINDS, UP
from master import FIGURES
from memory import MASTER, NODE, WEB
from model import COLUMNS, OURS, ROSCPP, ROSPY, Goal, Row, Step, at_least
from steps import Command, Import, Program, Script, Together


def both(script: str) -> dict[str, Step]:
    """A script's figures of our side and of stock's."""
    return {OURS: Script(script, "ours"), ROSPY: Script(script, "stock")}


def master() -> Iterator[Row]:
    for name, unit in FIGURES.items():
        yield Row("master", name, unit, name, both("master.py"), at_least(rospy=2), less=unit in ("ms", "us"))


LAUNCH_FILE = INTEROP / "launch_corpus" / "namespaces.launch"
ANSWERS = {
    "topic list": "rostopic list",
    "topic info /rosout": "rostopic info /rosout",
    "topic type /rosout": "rostopic type /rosout",
    "topic find rosgraph_msgs/Log": "rostopic find rosgraph_msgs/Log",
    "node list": "rosnode list",
    "node info -q /rosout": "rosnode info -q /rosout",
    "node ping -c 1 /rosout": "rosnode ping -c 1 /rosout",
    "service list": "rosservice list",
    "service type /rosout/get_loggers": "rosservice type /rosout/get_loggers",
    "param list": "rosparam list",
    "param get /": "rosparam get /",
    "param set /bench 1": "rosparam set /bench 1",
    "msg show sensor_msgs/PointCloud2": "rosmsg show sensor_msgs/PointCloud2",
    "msg md5 nav_msgs/Odometry": "rosmsg md5 nav_msgs/Odometry",
    "msg list": "rosmsg list",
    "srv show nav_msgs/GetPlan": "rossrv show nav_msgs/GetPlan",
    "version roscpp": "rosversion roscpp",
    "pkg find roscpp": "rospack find roscpp",
    "pkg list": "rospack list",
    f"launch --nodes {LAUNCH_FILE}": f"roslaunch --nodes {LAUNCH_FILE}",
    "wtf": "roswtf",
    "clean check": "rosclean check",
}
"""Commands that answer and end, and stock's."""


def start() -> Iterator[Row]:
    goal = at_least(rospy=3)
    steps: dict[str, Step] = {
        OURS: Import("from pyros1 import Node", OURS),
        ROSPY: Import("import rospy", ROSPY),
    }
    yield Row("start", "import of the library", "ms", "ms", steps, goal, less=True)
    publisher = Program(ROSPY, "latched")
    steps = {kind: Together((publisher, Program(kind, "first"))) for kind in COLUMNS}
    yield Row("start", "node's start to its first message", "ms", "first", steps, goal, less=True)
    del steps[ROSCPP]
    yield Row("start", "program's start to its node's first message", "ms", "whole", steps, goal, less=True)
    for ours, stock in ANSWERS.items():
        steps = {
            OURS: Command((STOCK_PYTHON, "-m", "pyros1", *ours.split()), ours=True),
            ROSPY: Command(tuple(stock.split()), ours=False),
        }
        name = ours.replace(f"{INTEROP.parent}/", "")
        yield Row("start", name, "ms", "ms", steps, goal if ours == "topic list" else (), less=True)


def memory() -> Iterator[Row]:
    """Each with the most that ours may need."""
    sides: dict[str, Step] = {OURS: Script("memory.py", "ours"), ROSPY: Script("memory.py", "rospy")}
    yield Row("memory", MASTER, "MB", MASTER, sides, (Goal(25, most=True),), less=True)
    sides = {**sides, ROSCPP: Script("memory.py", "roscpp")}
    yield Row("memory", NODE, "MB", NODE, sides, (Goal(20, most=True),), less=True)
    web: dict[str, Step] = {OURS: Script("memory.py", "ours", "--web", python=sys.executable)}
    yield Row("memory", "server of the page, without a page", "MB", WEB, web, (Goal(60, most=True),), less=True)


def launch() -> Iterator[Row]:
    about = {
        "light": "nodes that only register",
        "roscpp": "roscpp relays",
        "python": "Python nodes of ours",
        "preloaded": "Python nodes of ours, forked with --preload by ours",
        "own": "Python nodes, ours and rospy's",
    }
    for kind in KINDS:
        name, steps = f"50 {about[kind]}", both("launch.py")
        busy = kind in ("python", "preloaded")  # those take most of the time themselves, both times
        goal = () if busy else at_least(rospy=3)
        yield Row("launch", f"{name}: {UP}", "s", f"{kind} {UP}", steps, goal, less=True)
        yield Row("launch", f"{name}: {DOWN}", "s", f"{kind} {DOWN}", steps, less=True)
        if kind != "light":
            goal = at_least(rospy=3) if kind == "preloaded" else ()
            work = f"{name}: their own work on all processors"
            yield Row("launch", work, "s", f"{kind} {ALONE}", steps, goal, less=True)


def bags() -> Iterator[Row]:
    def row(name: str, unit: str, work: str, figure: str, goals: tuple[Goal, ...] = (), less: bool = True) -> Row:
        steps: dict[str, Step] = {OURS: BagWork("ours", work), ROSCPP: BagWork("stock", work)}
        return Row("bags", name, unit, f"{work}: {figure}", steps, goals, less)

    flood, images = "Float64 in a flood", "6.2 MB at 30 Hz"
    yield row("record Float64 in a flood", "messages/s", flood, RATE, at_least(roscpp=1), less=False)
    yield row("record Float64 in a flood: memory", "MB", flood, MEMORY)
    yield row("record Float64 at 50 kHz: in the bag", "%", "Float64 at 50 kHz", KEPT, at_least(roscpp=1), less=False)
    yield row("record images of 6.2 MB at 30 Hz: in the bag", "%", images, KEPT, (Goal(100),), less=False)
    yield row("record images of 6.2 MB at 30 Hz: CPU", "% of a core", images, CPU, at_least(roscpp=1))
    for name, rate in PLAYS.items():
        work, goals = f"play at {rate / 1e3:.0f} kHz", (Goal(1, most=True), *at_least(roscpp=1 if rate > 1e3 else None))
        yield row(f"{work}: error, median", "ms", name, MEDIAN)
        yield row(f"{work}: error, 99 %", "ms", name, P99, goals)
    steps: dict[str, Step] = {OURS: BagWork("ours", INFO), ROSPY: BagWork("stock", INFO)}
    yield Row("bags", "info of 10 GB", "s", f"{INFO}: {TIME}", steps, (Goal(1, most=True),), less=True)
    for work, type_name in READ.items():
        for side, name, python in (
            ("stock", f"read {type_name}", STOCK_PYTHON),
            ("rosbags", f"read {type_name}, beside rosbags", sys.executable),
        ):
            steps = {OURS: BagWork("ours", work, python), ROSPY: BagWork(side, work, python)}
            yield Row("bags", name, "messages/s", f"{work}: {READING}", steps, at_least(rospy=1))


def codec() -> Iterator[Row]:
    for label in LABELS:
        for work in ("encode", "decode"):
            yield Row("codec", f"{work} {label}", "ns", f"{work} {label}", both("codec.py"), less=True)
