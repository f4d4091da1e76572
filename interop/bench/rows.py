"""What is measured, and what is wanted: the rows of the table.

Columns of the groups master, start, launch and codec: the third one is rosmaster, rospy and rostopic, roslaunch, and
genpy. In the group bags the second one is stock's recorder and player, the third one rosbag in Python, or rosbags.
In the group rospy the first one is rospy of pyros1, the second one pyros1's own Node.
"""

from __future__ import annotations

import dataclasses
import itertools
import sys
from collections.abc import Iterator

from bag_steps import BagWork
from bags import CPU, INFO, KEPT, MEDIAN, MEMORY, P99, PLAY, RATE, READ, READING, TIME
from codec import LABELS
from harness import INTEROP, STOCK_PYTHON
from launch import ALONE, DOWN, KINDS, UP
from master import FIGURES
from model import COLUMNS, FACE, OURS, ROSCPP, ROSPY, Goal, Row, Step
from steps import LOCAL, Command, Crowd, FanOut, Import, Program, Script, Together


def at_least(roscpp: float | None = None, rospy: float | None = None) -> tuple[Goal, ...]:
    """So many times better than roscpp and rospy."""
    bounds = {ROSCPP: roscpp, ROSPY: rospy}
    return tuple(Goal(bound, column) for column, bound in bounds.items() if bound is not None)


def topic(subscriber: str, publisher: str, what: str, queue: str, publisher_queue: str = "") -> Together:
    """A subscriber of one kind, and a publisher of one kind that never rests."""
    pub = Program(publisher, "pub", f"{what} queue={publisher_queue or queue}")
    return Together((Program(subscriber, "sub", f"{what} queue={queue}"), pub), talking=0)


def best(kind: str) -> str:
    """The queue with which a library does best: for rospy that is none."""
    return "None" if kind == ROSPY else "1000"


def messages() -> Iterator[Row]:
    floats, rate = "type=Float64", ("messages/s", "rate")
    ours, roscpp = topic(OURS, OURS, floats, "1000"), topic(ROSCPP, ROSCPP, floats, "1000")
    queued, direct = topic(ROSPY, ROSPY, floats, "1000"), topic(ROSPY, ROSPY, floats, "None")
    steps = {OURS: ours, ROSCPP: roscpp, ROSPY: queued}
    yield Row("messages", "Float64", *rate, steps, at_least(4, 50))
    yield Row("messages", "Float64, rospy without queue", *rate, {OURS: ours, ROSCPP: roscpp, ROSPY: direct})
    steps = {kind: topic(kind, ROSCPP, floats, "1000") for kind in COLUMNS}
    yield Row("messages", "Float64 from roscpp", *rate, steps, at_least(rospy=1.5))
    steps = {kind: topic(ROSCPP, kind, floats, "1000", best(kind)) for kind in COLUMNS}
    yield Row("messages", "Float64 to roscpp", *rate, steps, at_least(roscpp=1))
    for name, what in (
        ("Twist", "type=Twist"),
        ("JointState, 7 joints", "type=JointState"),
        ("Odometry", "type=Odometry"),
        ("String, 100 B", "type=String"),
        ("TFMessage, 20 transforms", "type=TFMessage"),
    ):
        steps = {kind: topic(kind, kind, what, best(kind)) for kind in COLUMNS}
        yield Row("messages", name, *rate, steps, at_least(1, 2))


def images() -> Iterator[Row]:
    bandwidth = ("MB/s", "mb")
    for name, what in (
        ("Image 1 MB", "type=Image size=1000000"),
        ("Image 6.2 MB", "type=Image size=6220800"),
        ("PointCloud2 10 MB", "type=PointCloud2 size=10000000"),
    ):
        alone = {kind: topic(kind, kind, what, "10") for kind in COLUMNS}
        from_roscpp = {kind: topic(kind, ROSCPP, what, "10") for kind in COLUMNS}
        yield Row("images", name, *bandwidth, alone, at_least(roscpp=1))
        yield Row("images", f"{name} from roscpp", *bandwidth, from_roscpp, at_least(roscpp=1))
        alone = {**alone, OURS: topic(OURS, OURS, f"{what} arrays=memoryview", "10")}
        yield Row("images", f"{name}, as memoryviews", *bandwidth, alone)


def latency() -> Iterator[Row]:
    for name, count in (("round trip", 0), ("round trip beside 20 topics", 20)):
        options = {kind: f"queue={best(kind)} count={count}" for kind in COLUMNS}
        steps = {
            kind: Together((Program(kind, "echo", options[kind]), Program(kind, "ping", options[kind])))
            for kind in COLUMNS
        }
        yield Row("latency", f"{name}, median", "us", "p50", steps, at_least(1, 1), less=True)
        yield Row("latency", f"{name}, 99 %", "us", "p99", steps, at_least(1, 1), less=True)
    steps = {kind: Together((Program(kind, "sub"), Program(kind, "rate"))) for kind in COLUMNS}
    jitter = "publisher at 1 kHz: interval off by, 99 %"
    yield Row("latency", jitter, "us", "jitter99", steps, at_least(roscpp=0.667), less=True)
    yield Row("latency", "publisher at 1 kHz: CPU", "% of a core", "cpu", steps, at_least(rospy=1), less=True)


def local() -> Iterator[Row]:
    """Nodes of one machine: our local transport beside TCP of the others. Subscribers read images in place."""
    for name, what in (
        ("Image 6.2 MB", "type=Image size=6220800"),
        ("PointCloud2 10 MB", "type=PointCloud2 size=10000000"),
    ):
        options = dict.fromkeys(COLUMNS, f"{what} queue=10")
        options[OURS] += f" arrays=memoryview {LOCAL}"
        for count, goal in ((1, 2), (5, 6), (10, 10)):
            steps = {kind: Crowd(kind, options[kind], count) for kind in COLUMNS}
            yield Row("local", f"{name} to {count}, each a process: in all", "MB/s", "mb", steps, at_least(roscpp=goal))
    options = {kind: f"queue={best(kind)}{f' {LOCAL}' if kind == OURS else ''}" for kind in COLUMNS}
    steps = {
        kind: Together((Program(kind, "echo", options[kind]), Program(kind, "ping", options[kind]))) for kind in COLUMNS
    }
    yield Row("local", "round trip, median", "us", "p50", steps, at_least(1 / 0.6, 1 / 0.6), less=True)
    yield Row("local", "round trip, 99 %", "us", "p99", steps, less=True)
    steps = {
        kind: Together(
            (Program(kind, "echo", f"{options[kind]} low=1"), Program(kind, "ping", f"{options[kind]} low=1"))
        )
        for kind in COLUMNS
    }
    yield Row("local", "round trip, low latency, median", "us", "p50", steps, at_least(roscpp=4), less=True)
    yield Row("local", "round trip, low latency, 99 %", "us", "p99", steps, less=True)
    floats = {kind: f"type=Float64 {LOCAL}" if kind == OURS else "type=Float64" for kind in COLUMNS}
    steps = {kind: topic(kind, kind, floats[kind], best(kind)) for kind in COLUMNS}
    yield Row("local", "Float64", "messages/s", "rate", steps, at_least(4, 50))


def fan_out() -> Iterator[Row]:
    for name, options, links in (
        ("Float64 to 1 + 1", "type=Float64 queue=100", 1),
        ("Float64 to 10 + 1", "type=Float64 queue=100", 10),
        ("Float64 to 50 + 1", "type=Float64 queue=100", 50),
        ("Image 100 kB to 10 + 1", "type=Image queue=10 size=100000", 10),
    ):
        steps = {kind: FanOut(kind, options, links) for kind in COLUMNS}
        yield Row("fan-out", name, "messages/s each", "free", steps)
        yield Row("fan-out", f"{name}, that one is stuck", "messages/s each", "held", steps)
        yield Row("fan-out", f"{name}, kept of the rate if that one is stuck", "%", "kept", steps, (Goal(80),))
        grown = f"{name}, publisher's growth with a stuck one"
        yield Row("fan-out", grown, "MB", "rss", steps, (Goal(20, most=True),), less=True)


def services() -> Iterator[Row]:
    for kind_of_service in ("Empty", "SetBool"):
        for name, persistent in (("new connection", 0), ("persistent", 1)):
            options = f"type={kind_of_service} persistent={persistent}"
            steps = {
                kind: Together((Program(kind, "srv", options), Program(kind, "call", options))) for kind in COLUMNS
            }
            yield Row("services", f"{kind_of_service}, {name}", "calls/s", "rate", steps, at_least(1, 1))


def process() -> Iterator[Row]:
    steps = {kind: Together((Program(kind, "within", "type=Float64 queue=1000"),)) for kind in COLUMNS}
    yield Row("process", "Float64 within one process", "messages/s", "rate", steps, at_least(rospy=1))
    steps = {kind: Together((Program(kind, "within", "type=Image size=1000000 queue=10"),)) for kind in COLUMNS}
    yield Row("process", "Image 1 MB within one process", "messages/s", "rate", steps, at_least(rospy=1))
    many = Program(ROSCPP, "many", "count=200")
    steps = {kind: Together((many, Program(kind, "idle", "count=200"))) for kind in COLUMNS}
    yield Row("process", "200 idle links: memory of a link", "kB", "rss", steps, less=True)
    yield Row("process", "200 idle links: threads", "threads", "threads", steps, at_least(rospy=4), less=True)
    limit = (Goal(50, most=True),)
    yield Row("process", "200 idle links: CPU in 5 s", "ms", "cpu", steps, limit, less=True)


def faces() -> Iterator[Row]:
    """The rows above once more, for programs that use rospy: on our modules, with our Node, on stock's modules."""
    for row in itertools.chain(messages(), images(), latency(), fan_out(), services(), process(), start()):
        ours = as_face(row.steps[OURS])
        # rospy's messages hold bytes; and it loads the library of nodes when the node starts, so only the whole tells.
        if ours == row.steps[OURS] or "memoryview" in row.name or row.figure == "first":
            continue
        steps = {OURS: ours, ROSCPP: row.steps[OURS], ROSPY: row.steps[ROSPY]}
        goals = (Goal(0.9, ROSCPP, "our Node"), *(goal for goal in row.goals if goal.than == ROSPY))
        yield dataclasses.replace(row, group="rospy", name=f"{row.group}: {row.name}", steps=steps, goals=goals)


def as_face(step: Step) -> Step:
    """The same step with rospy programs on our modules in place of our Node."""
    match step:
        case Together(programs):
            face = tuple(dataclasses.replace(one, kind=FACE) if one.kind == OURS else one for one in programs)
            return dataclasses.replace(step, programs=face)
        case FanOut(kind) if kind == OURS:
            return dataclasses.replace(step, kind=FACE)
        case Import(_, kind) if kind == OURS:
            return Import("import rospy", FACE)
    return step


def both(script: str) -> dict[str, Step]:
    """A script's figures of our side and of stock's."""
    return {OURS: Script(script, "ours"), ROSPY: Script(script, "stock")}


def master() -> Iterator[Row]:
    for name, unit in FIGURES.items():
        yield Row("master", name, unit, name, both("master.py"), at_least(rospy=2), less=unit == "ms")


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


def launch() -> Iterator[Row]:
    about = {
        "light": "nodes that only register",
        "roscpp": "roscpp relays",
        "python": "Python nodes of ours",
        "own": "Python nodes, ours and rospy's",
    }
    for kind in KINDS:
        name, steps = f"50 {about[kind]}", both("launch.py")
        goal = at_least(rospy=3) if kind != "python" else ()  # those take most of the time themselves, both times
        yield Row("launch", f"{name}: {UP}", "s", f"{kind} {UP}", steps, goal, less=True)
        yield Row("launch", f"{name}: {DOWN}", "s", f"{kind} {DOWN}", steps, less=True)
        if kind != "light":
            yield Row("launch", f"{name}: their own work on all processors", "s", f"{kind} {ALONE}", steps, less=True)


def bags() -> Iterator[Row]:
    def row(name: str, unit: str, work: str, figure: str, goals: tuple[Goal, ...] = (), less: bool = True) -> Row:
        steps: dict[str, Step] = {OURS: BagWork("ours", work), ROSCPP: BagWork("stock", work)}
        return Row("bags", name, unit, f"{work}: {figure}", steps, goals, less)

    flood, images = "Float64 in a flood", "6.2 MB at 30 Hz"
    yield row("record Float64 in a flood", "messages/s", flood, RATE, at_least(roscpp=1), less=False)
    yield row("record Float64 in a flood: memory", "MB", flood, MEMORY)
    yield row("record Float64 at 50 kHz: in the bag", "%", "Float64 at 50 kHz", KEPT, at_least(roscpp=1), less=False)
    yield row("record images of 6.2 MB at 30 Hz: in the bag", "%", images, KEPT, (Goal(100),), less=False)
    yield row("record images of 6.2 MB at 30 Hz: CPU", "% of a core", images, CPU)
    yield row("play at 1 kHz: error, median", "ms", PLAY, MEDIAN)
    yield row("play at 1 kHz: error, 99 %", "ms", PLAY, P99, (Goal(1, most=True),))
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


QUICK = {
    "messages: Float64",
    "messages: Float64 from roscpp",
    "images: Image 1 MB",
    "local: Image 6.2 MB to 5, each a process: in all",
    "latency: round trip, median",
    "latency: round trip, 99 %",
    "fan-out: Float64 to 1 + 1",
    "services: Empty, persistent",
    "rospy: messages: Float64",
    "process: Float64 within one process",
    "master: getParam",
    "start: import of the library",
    "start: topic list",
    "codec: encode Imu",
}
"""The rows of the quick form."""


def all_rows() -> list[Row]:
    """The whole table."""
    groups = (messages, images, latency, local, fan_out, services, faces, process, master, start, launch, bags, codec)
    return [row for group in groups for row in group()]
