"""What is measured, and what is wanted: the rows of the table.

Columns of the groups master, start, launch and codec: the third one is rosmaster, rospy and rostopic, roslaunch, and
genpy. In the group bags the second one is stock's recorder and player, the third one rosbag in Python, or rosbags.
In the group rospy the first one is pyros1's rospy, the second one pyros1's own Node.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator

from model import COLUMNS, FACE, OURS, ROSCPP, ROSPY, Goal, Row, Step, at_least
from program_rows import bags, codec, launch, master, memory, start
from robot_rows import robot_nodes
from steps import LOCAL, ControlLoop, Crowd, FanOut, Import, Program, Together


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
    steps = {OURS: topic(OURS, OURS, floats, "None"), ROSPY: direct}
    yield Row("messages", "Float64, both without queue", *rate, steps, at_least(rospy=1.2))
    steps = {kind: topic(kind, ROSCPP, floats, "1000") for kind in COLUMNS}
    yield Row("messages", "Float64 from roscpp", *rate, steps, at_least(rospy=1.5))
    steps = {kind: topic(ROSCPP, kind, floats, "1000", best(kind)) for kind in COLUMNS}
    yield Row("messages", "Float64 to roscpp", *rate, steps, at_least(roscpp=1))
    for name, what in (
        ("Twist", "type=Twist"),
        ("JointState, 7 joints", "type=JointState"),
        ("Odometry", "type=Odometry"),
        ("String, 100 B", "type=String"),
        ("Imu", "type=Imu"),
        ("LaserScan, 720 ranges", "type=LaserScan"),
        ("PoseArray, 100 poses", "type=PoseArray"),
        ("MarkerArray, 100 markers", "type=MarkerArray"),
        ("DiagnosticArray, 20 statuses of 5 values", "type=DiagnosticArray"),
        ("TFMessage, 20 transforms", "type=TFMessage"),
    ):
        steps = {kind: topic(kind, kind, what, best(kind)) for kind in COLUMNS}
        yield Row("messages", name, *rate, steps, at_least(0.7 if "TFMessage" in name else 1, 2))
        if "PoseArray" in name:
            columns = topic(OURS, OURS, "type=PoseColumns arrays=numpy", best(OURS))
            yield Row("messages", f"{name}, as numpy arrays", *rate, {**steps, OURS: columns}, at_least(1, 2))
    sender = Program(ROSCPP, "tf_sends")
    steps = {kind: Together((Program(kind, "tf_hears"), sender), talking=0) for kind in COLUMNS}
    listener = "tf listener at 1 kHz: TFMessage of 20 transforms: CPU of a message"
    yield Row("messages", listener, "us", "cpu", steps, at_least(1, 1), less=True)


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
    heard = {kind: Together((Program(OURS, "arrivals"), Program(kind, "rate")), talking=0) for kind in COLUMNS}
    arrivals = "publisher at 1 kHz: interval of arrivals off by, 99 %"
    yield Row("latency", arrivals, "us", "jitter99", heard, at_least(roscpp=0.667), less=True)
    yield Row("latency", "publisher at 1 kHz: CPU", "% of a core", "cpu", steps, at_least(rospy=1), less=True)


def local() -> Iterator[Row]:
    """Nodes of one machine: our local transport beside TCP of the others. Subscribers read images in place."""
    steps: dict[str, Step]
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
    yield from calls("local", LOCAL)


def control() -> Iterator[Row]:
    """A loop of three processes, from the sensor's clock to the actuator's callback."""
    others = {kind: ControlLoop(kind, f"queue={best(kind)}") for kind in (ROSCPP, ROSPY)}
    limit = (Goal(500, most=True),)
    for name, options, goals in (
        ("", "", ()),
        (", low latency", " low=1", limit),
        (", low latency, local", f" low=1 {LOCAL}", limit),
    ):
        steps: dict[str, Step] = {OURS: ControlLoop(OURS, f"queue={best(OURS)}{options}"), **others}
        loop = f"sensor, controller, actuator at 1 kHz{name}"
        yield Row("loop", f"{loop}: median", "us", "p50", steps, less=True)
        yield Row("loop", f"{loop}: 99 %", "us", "p99", steps, goals, less=True)
        yield Row("loop", f"{loop}: CPU of the three", "% of a core", "cpu", steps, less=True)


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
    yield from calls("services", "")


def calls(group: str, transport: str) -> Iterator[Row]:
    """Calls of services, with that option of ours."""
    for kind_of_service in ("Empty", "SetBool"):
        for name, persistent in (("new connection", 0), ("persistent", 1)):
            words = f"type={kind_of_service} persistent={persistent}"
            options = dict.fromkeys(COLUMNS, words) | {OURS: f"{words} {transport}".rstrip()}
            steps = {
                kind: Together((Program(kind, "srv", options[kind]), Program(kind, "call", options[kind])))
                for kind in COLUMNS
            }
            label = f"service {kind_of_service}, {name}" if transport else f"{kind_of_service}, {name}"
            yield Row(group, label, "calls/s", "rate", steps, at_least(1.3, 1.3))


def process() -> Iterator[Row]:
    steps = {kind: Together((Program(kind, "within", "type=Float64 queue=1000"),)) for kind in COLUMNS}
    yield Row("process", "Float64 within one process", "messages/s", "rate", steps, at_least(1, 1))
    steps = {kind: Together((Program(kind, "within", "type=Image size=1000000 queue=10"),)) for kind in COLUMNS}
    yield Row("process", "Image 1 MB within one process", "messages/s", "rate", steps, at_least(rospy=1))
    many = Program(ROSCPP, "many", "count=200")
    steps = {kind: Together((many, Program(kind, "idle", "count=200"))) for kind in COLUMNS}
    yield Row("process", "200 idle links: memory of a link", "kB", "rss", steps, less=True)
    yield Row("process", "200 idle links: threads", "threads", "threads", steps, at_least(rospy=4), less=True)
    limit = (Goal(50, most=True),)
    yield Row("process", "200 idle links: CPU in 5 s", "ms", "cpu", steps, limit, less=True)
    roles = ("hears", "beats")  # the one that is not measured is roscpp's
    for name, role, options in (
        ("publisher", "beats", "count=20"),
        ("subscriber", "hears", "count=20"),
        ("subscriber, each topic at its own time", "hears", "count=20 apart=1"),
    ):
        steps = {}
        for kind in COLUMNS:
            mine, other = Program(kind, role, f"{options} queue={best(kind)}"), f"{options} queue=1000"
            pair = tuple(mine if one == role else Program(ROSCPP, one, other) for one in roles)
            steps[kind] = Together(pair, roles.index(role))
        topics = f"20 topics at 100 Hz: CPU of the {name}"
        yield Row("process", topics, "% of a core", "cpu", steps, at_least(rospy=1), less=True)


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


QUICK = {
    "messages: Float64",
    "messages: Float64 from roscpp",
    "messages: tf listener at 1 kHz: TFMessage of 20 transforms: CPU of a message",
    "images: Image 1 MB",
    "local: Image 6.2 MB to 5, each a process: in all",
    "latency: round trip, median",
    "latency: round trip, 99 %",
    "loop: sensor, controller, actuator at 1 kHz, low latency: 99 %",
    "fan-out: Float64 to 1 + 1",
    "services: Empty, persistent",
    "rospy: messages: Float64",
    "process: Float64 within one process",
    "master: getParam",
    "start: import of the library",
    "start: topic list",
    "codec: encode Imu",
    "robot nodes: image_proc: debayer, 640 x 480, 30 Hz",
}
"""The rows of the quick form."""


def all_rows() -> list[Row]:
    """The whole table."""
    groups = (
        messages,
        images,
        latency,
        local,
        control,
        fan_out,
        services,
        faces,
        process,
        memory,
        master,
        start,
        launch,
        bags,
        codec,
        robot_nodes,
    )
    return [row for group in groups for row in group()]
