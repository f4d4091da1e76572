"""Stock topic_tools and ours in turn: the same input, the same output, the same services and exit codes (L187-L194).

Feature: topic_tools: relay, drop, throttle, mux, demux, transform, relay_field -- messages are forwarded undecoded:
    no message packages needed
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import pytest
from harness import Master, Peer, Process, until

OWN_MASTER = True
MASTERS = ("ours",)  # stock's tool and ours are compared, whatever the master

TEXT, JOINTS, IMAGE = "std_msgs/String", "sensor_msgs/JointState", "sensor_msgs/Image"
Run = Callable[..., Process]


@pytest.fixture(params=["stock", "ours"])
def whose(request: pytest.FixtureRequest) -> str:
    """Whose tools a test runs."""
    return str(request.param)


def command(whose: str, tool: str, arguments: Sequence[str]) -> list[str]:
    first = (
        [f"/usr/lib/topic_tools/{tool}"] if whose == "stock" else [sys.executable, "-m", "pyros1", "topic_tools", tool]
    )
    return [*first, *arguments]


@pytest.fixture
def run(launcher: Master, whose: str) -> Run:
    """Starts a tool, and waits until it subscribes to a topic."""

    def start(tool: str, *arguments: str, subscribes: str = "") -> Process:
        python = "ours" if whose == "ours" else "stock"
        process = launcher.run(command(whose, tool, arguments), python=python, label=f"{whose} {tool}")
        if subscribes:
            until(lambda: any(f"_{tool}_" in name for name in launcher.subscribers(subscribes)), f"{tool} subscribes")
        return process

    return start


def tool(master: Master, whose: str, name: str, *arguments: str, code: int = 0) -> str:
    """Run a tool to its end; returns what it prints."""
    process = master.run(command(whose, name, arguments), python="ours" if whose == "ours" else "stock", label=name)
    assert process.wait() == code, process.transcript()
    return "\n".join(process.lines)


def linked_output(ours: Peer, master: Master, target: str) -> None:
    """Wait until the tool counts our subscriber in."""
    ours.linked(target)
    master.sends(target)


def primed(ours: Peer, master: Master, source: str, target: str, type_name: str = TEXT) -> None:
    """Let the tool advertise its output by one message, and subscribe to it then."""
    ours.linked(source)
    ours.publish(source, 0)
    until(lambda: master.publishers(target), f"{target} is advertised")
    ours.subscribe(target, type_name)
    linked_output(ours, master, target)


def sent_and_got(ours: Peer, source: str, target: str, seeds: Sequence[int]) -> tuple[list[str], list[str]]:
    """Send messages and a last one, which must come; returns what was sent, and what came up to that one.

    Not what came before the first of them: the message that primed the tool may be late.
    """
    bodies = [ours.publish(source, seed) for seed in seeds]
    got: list[str] = []
    while not got or got[-1] != bodies[-1]:
        body = ours.received(target)
        if got or body in bodies:
            got.append(body)
    return bodies, got


def test_relay(ours: Peer, run: Run, launcher: Master, topic: str) -> None:
    ours.advertise(topic, TEXT)
    run("relay", topic, subscribes=topic)
    primed(ours, launcher, topic, topic + "_relay")
    bodies, got = sent_and_got(ours, topic, topic + "_relay", range(1, 9))
    assert got == bodies
    header = ours.header(topic + "_relay")
    assert (header["type"], header["latching"]) == (TEXT, "0")


def test_relay_is_latched_as_its_input(ours: Peer, run: Run, topic: str) -> None:
    ours.advertise(topic, TEXT, latch=True)
    body = ours.publish(topic, 5)
    run("relay", topic, topic + "/again", subscribes=topic)
    ours.linked(topic)
    ours.subscribe(topic + "/again", TEXT)
    assert ours.received(topic + "/again") == body
    assert ours.header(topic + "/again")["latching"] == "1"


def test_relay_of_images(ours: Peer, run: Run, launcher: Master, topic: str) -> None:
    ours.advertise(topic, IMAGE)
    run("relay", topic, subscribes=topic)
    primed(ours, launcher, topic, topic + "_relay", IMAGE)
    bodies, got = sent_and_got(ours, topic, topic + "_relay", range(1, 4))
    assert got == bodies


def test_lazy_relay(ours: Peer, run: Run, launcher: Master, topic: str) -> None:
    """Without subscribers the first message ends its subscription; the first subscriber brings it back."""
    ours.advertise(topic, TEXT)
    run("relay", topic, "_lazy:=true", subscribes=topic)
    ours.linked(topic)
    ours.publish(topic, 1)
    ours.linked(topic, 0)
    assert not launcher.subscribers(topic)
    ours.subscribe(topic + "_relay", TEXT)
    linked_output(ours, launcher, topic + "_relay")
    ours.linked(topic)
    bodies, got = sent_and_got(ours, topic, topic + "_relay", [2, 3])
    assert got == bodies


def test_stealthy_relay(ours: Peer, run: Run, whose: str, launcher: Master, topic: str) -> None:
    """It subscribes only while another node subscribes to the monitored topic."""
    ours.advertise(topic, TEXT)
    watched = topic + "/watched"
    run("relay", topic, "_stealth:=true", f"_monitor_topic:={watched}", "_monitor_rate:=20.0")
    if whose == "ours":  # stock's does so late, or never
        until(lambda: not launcher.subscribers(topic), "it is hidden")
    ours.subscribe(watched, TEXT)
    until(lambda: launcher.subscribers(topic), "it comes out")
    if whose == "ours":
        ours.ask("unsub", watched, event=f"unsubscribed {watched}")
        until(lambda: not launcher.subscribers(topic), "it hides again")


@pytest.mark.parametrize(("dropped", "among"), [(1, 2), (2, 5), (0, 3)])
def test_drop(ours: Peer, run: Run, launcher: Master, topic: str, dropped: int, among: int) -> None:
    ours.advertise(topic, TEXT)
    run("drop", topic, str(dropped), str(among), subscribes=topic)
    primed(ours, launcher, topic, topic + "_drop")  # that was the first of Y; stock loses what is more than ten at once
    bodies, got = sent_and_got(ours, topic, topic + "_drop", range(1, 10))
    assert got == [body for number, body in enumerate(bodies, 1) if number % among >= dropped]


def test_throttle_messages(ours: Peer, run: Run, launcher: Master, topic: str) -> None:
    """All but the first message come too early, and are left out: a relay shows that the throttle had them."""
    ours.advertise(topic, TEXT)
    run("throttle", "messages", topic, "0.001", "_wall_clock:=true", subscribes=topic)
    primed(ours, launcher, topic, topic + "_throttle")
    run("throttle", "messages", topic, "1000000", topic + "/all")
    ours.linked(topic, 2)
    early = [ours.publish(topic, 1)]
    until(lambda: launcher.publishers(topic + "/all"), "it is advertised")
    ours.subscribe(topic + "/all", TEXT)
    linked_output(ours, launcher, topic + "/all")
    bodies, got = sent_and_got(ours, topic, topic + "/all", [2])
    assert got == bodies
    early += bodies
    assert not [line for line in ours.unread(rf"^got {topic}_throttle ") if line.split()[-1] in early]


def test_throttle_bytes(ours: Peer, run: Run, launcher: Master, topic: str) -> None:
    """Messages pass until the window holds the number of bytes."""
    ours.advertise(topic, "std_msgs/Int64")
    run("throttle", "bytes", topic, "36", "1000", topic + "/some", subscribes=topic)
    primed(ours, launcher, topic, topic + "/some", "std_msgs/Int64")
    bodies = [ours.publish(topic, seed) for seed in range(1, 9)]
    got = [ours.received(topic + "/some")]
    while got[-1] != bodies[3]:
        got.append(ours.received(topic + "/some"))
    assert got[-4:] == bodies[:4] and len(got) <= 5, (
        "the first message of all may still come, too"
    )  # 5 times 8 bytes passed before 36 were reached
    assert not ours.unread(rf"^got {topic}/some ")


def test_throttle_is_latched_by_force(ours: Peer, run: Run, topic: str) -> None:
    ours.advertise(topic, TEXT)
    run("throttle", "messages", topic, "100.0", "_force_latch:=true", subscribes=topic)
    ours.linked(topic)
    body = ours.publish(topic, 1)
    ours.subscribe(topic + "_throttle", TEXT)
    assert ours.received(topic + "_throttle") == body


def selected(master: Master, name: str) -> str:
    return master.tool("rostopic", "echo", "-n", "1", name + "/selected").splitlines()[0]


@pytest.mark.parametrize("helper", ["stock", "ours"])
def test_mux(ours: Peer, run: Run, launcher: Master, topic: str, helper: str) -> None:
    """Its services, by the helpers of both; what passes; what is refused."""
    left, right, third, out, name = (topic + part for part in ("/left", "/right", "/third", "/out", "/mux"))
    for source in (left, right, third):
        ours.advertise(source, TEXT)
    run("mux", out, left, right, f"mux:={name}", subscribes=right)
    assert selected(launcher, name) == f'data: "{left}"'
    primed(ours, launcher, left, out)
    ours.linked(right)
    sent_and_got(ours, left, out, [1])  # the first message of all may still come, too
    assert tool(launcher, helper, "mux_list", name).endswith(f"\n['{left}', '{right}']")
    tool(launcher, helper, "mux_select", name, right)
    assert selected(launcher, name) == f'data: "{right}"'
    ours.publish(left, 2)
    assert ours.publish(right, 3) == ours.received(out)
    tool(launcher, helper, "mux_add", name, third)
    ours.linked(third)
    tool(launcher, helper, "mux_select", name, third)
    assert ours.publish(third, 4) == ours.received(out)
    tool(launcher, helper, "mux_delete", name, right)
    ours.linked(right, 0)
    assert tool(launcher, helper, "mux_list", name).endswith(f"\n['{left}', '{third}']")
    failed = 0 if helper == "stock" else 1
    for verb, wrong in (("select", right), ("delete", third), ("delete", right), ("add", left), ("add", "__none")):
        assert "Service call failed" in tool(launcher, helper, f"mux_{verb}", name, wrong, code=failed)
    tool(launcher, helper, "switch_mux", out, left)
    assert selected(launcher, name) == f'data: "{left}"'
    tool(launcher, helper, "mux_select", name, "__none")
    assert selected(launcher, name) == 'data: "__none"'
    ours.publish(left, 5)
    tool(launcher, helper, "mux_select", name, left)
    assert ours.publish(left, 6) == ours.received(out)


@pytest.mark.parametrize(("initial", "data"), [("__none", "__none"), ("{}/b", "{}/b"), ("/nowhere", "__none")])
def test_mux_begins_with(run: Run, launcher: Master, topic: str, initial: str, data: str) -> None:
    arguments = [f"mux:={topic}/mux", f"_initial_topic:={initial.format(topic)}"]
    run("mux", topic, topic + "/a", topic + "/b", *arguments, subscribes=topic + "/b")
    assert selected(launcher, topic + "/mux") == f'data: "{data.format(topic)}"'


def test_lazy_mux(ours: Peer, run: Run, launcher: Master, topic: str) -> None:
    """Once its type is known it keeps the selected input only, and that only while somebody listens."""
    left, right, out, name = (topic + part for part in ("/left", "/right", "/out", "/mux"))
    ours.advertise(left, TEXT)
    ours.advertise(right, TEXT)
    run("mux", out, left, right, f"mux:={name}", "_lazy:=true", subscribes=right)
    ours.linked(left)
    ours.linked(right)
    ours.publish(left, 1)
    ours.linked(left, 0)
    ours.linked(right, 0)
    ours.subscribe(out, TEXT)
    linked_output(ours, launcher, out)
    ours.linked(left)
    assert ours.publish(left, 2) == ours.received(out)
    launcher.tool("rosservice", "call", name + "/select", right)
    ours.linked(left, 0)
    ours.linked(right)
    assert ours.publish(right, 3) == ours.received(out)


def test_demux(ours: Peer, run: Run, launcher: Master, topic: str) -> None:
    left, right, third, name = (topic + part for part in ("/left", "/right", "/third", "/demux"))
    ours.advertise(topic, TEXT)
    for target in (left, right, third):
        ours.subscribe(target, TEXT)
    run("demux", topic, left, right, f"demux:={name}", subscribes=topic)
    assert selected(launcher, name) == f'data: "{left}"'
    ours.linked(topic)
    assert ours.publish(topic, 1) == ours.received(left)  # the first message waits for its subscribers
    linked_output(ours, launcher, right)
    assert f'prev_topic: "{left}"' in launcher.tool("rosservice", "call", name + "/select", right)
    assert ours.publish(topic, 2) == ours.received(right)
    launcher.tool("rosservice", "call", name + "/add", third)
    launcher.tool("rosservice", "call", name + "/select", third)
    assert ours.publish(topic, 3) == ours.received(third)
    launcher.tool("rosservice", "call", name + "/delete", right)
    ours.linked(right, 0)
    listed = launcher.tool("rosservice", "call", name + "/list")
    assert left in listed and third in listed and right not in listed
    for verb, wrong in (("select", right), ("delete", third), ("delete", right), ("add", left), ("add", "__none")):
        launcher.tool("rosservice", "call", f"{name}/{verb}", wrong, code=2)


@pytest.mark.parametrize(
    ("field", "type_name", "expression"),
    [
        ("/data", "std_msgs/String", "m.upper() + '!'"),
        ("", "std_msgs/Int64", "len(m.data)"),
        ("", "std_msgs/String", "m"),
        ("/data", "std_msgs/Float64", "numpy.sqrt(numpy.sum(numpy.array([3.0, 4.0]) * [3, 4]))"),
        ("/data", "std_msgs/ColorRGBA", "[0.25, 0.5, len(m), 1]"),
        ("/data", "geometry_msgs/Vector3", "numpy.array([1, 2, 3]).tolist()"),
    ],
)
def test_transform(ours: Peer, launcher: Master, topic: str, field: str, type_name: str, expression: str) -> None:
    """One message, through both at once."""
    ours.advertise(topic, TEXT)
    for whose in ("stock", "ours"):
        launcher.run(
            command(whose, "transform", [topic + field, f"{topic}/{whose}", type_name, expression, "--wait-for-start"]),
            python=whose,
        )
        ours.subscribe(f"{topic}/{whose}", "*")
    same_output(ours, launcher, topic)


@pytest.mark.parametrize(
    "fields",
    ["{seq: '3', stamp: {secs: '1', nsecs: '2'}, frame_id: m.data}", "{frame_id: base_link}", "frame_id: m.data[1:3]"],
)
def test_relay_field(ours: Peer, launcher: Master, topic: str, fields: str) -> None:
    """Texts only: under Python 3 stock fails at numbers."""
    ours.advertise(topic, TEXT)
    for whose in ("stock", "ours"):
        arguments = [topic, f"{topic}/{whose}", "std_msgs/Header", fields, "--wait-for-start"]
        launcher.run(command(whose, "relay_field", arguments), python=whose)
        ours.subscribe(f"{topic}/{whose}", "*")
    same_output(ours, launcher, topic)


def same_output(ours: Peer, master: Master, topic: str) -> None:
    ours.linked(topic, 2)
    linked_output(ours, master, topic + "/stock")
    linked_output(ours, master, topic + "/ours")
    ours.publish(topic, 3)
    stock, mine = ours.received(topic + "/stock"), ours.received(topic + "/ours")
    assert mine == stock
    names = ("type", "md5sum")
    first, second = ours.header(topic + "/stock"), ours.header(topic + "/ours")
    assert [first[name] for name in names] == [second[name] for name in names]


WRONG: list[tuple[str, list[str]]] = [
    ("relay", []),
    ("drop", ["/a", "1"]),
    ("drop", ["/a", "-1", "2"]),
    ("drop", ["/a", "1", "0"]),
    ("throttle", []),
    ("throttle", ["messages", "/a"]),
    ("throttle", ["bytes", "/a", "10"]),
    ("throttle", ["words", "/a", "10"]),
    ("mux", ["/a"]),
    ("demux", ["/a"]),
    ("mux_select", ["/mux"]),
    ("mux_add", []),
    ("mux_delete", ["/mux"]),
    ("mux_list", []),
    ("switch_mux", ["/a"]),
    ("transform", ["/a"]),
    ("transform", ["/nowhere", "/b", "std_msgs/String", "m"]),
    ("relay_field", []),
    ("relay_field", ["/nowhere", "/b", "std_msgs/String", "data: m"]),
]


@pytest.mark.parametrize(("name", "arguments"), WRONG, ids=[" ".join([name, *words]) for name, words in WRONG])
def test_wrong_usage(launcher: Master, name: str, arguments: list[str]) -> None:
    """The same exit code."""
    codes = []
    for whose in ("stock", "ours"):
        process = launcher.run(command(whose, name, arguments), python=whose)
        codes.append(process.wait())
        assert process.lines, "it says what is wrong"
    assert codes[0] == codes[1] != 0


REMAPPINGS = [
    "a:=b",
    "b:=c",
    "in:=/i",
    "/i:=/j",
    "out:=oo",
    "/oo:=/ooo",
    "mux:=mm",
    "mm/list:=ml",
    "mux/select:=ms",
    "demux:=dd",
]
"""Some have a target that is remapped, too: a name is remapped once where it is given."""


@pytest.mark.parametrize(
    ("tool", "arguments"),
    [
        ("relay", ["a"]),
        ("relay", ["in", "out"]),
        ("throttle", ["messages", "in", "5", "out"]),
        ("drop", ["a", "1", "2"]),
        ("mux", ["out", "a", "b", "in"]),
        ("demux", ["in", "out", "a"]),
    ],
)
def test_names_are_remapped_as_stocks(launcher: Master, tool: str, arguments: list[str]) -> None:
    count = {"mux": 11, "demux": 9}.get(tool, 4)  # with /rosout and the logger services

    found = []
    for whose in ("stock", "ours"):
        name = f"{whose}_{tool}_{len(arguments)}"
        words = [*arguments, *REMAPPINGS, f"__name:={name}"]
        process = launcher.run(command(whose, tool, words), python=whose, label=f"{whose} {tool}")
        until(lambda: len(registrations(launcher, name)) >= count, f"{name} is there")  # noqa: B023
        found.append({each.replace(name, "tool") for each in registrations(launcher, name)})
        process.close()  # a service has one provider
    assert found[0] == found[1]


def registrations(master: Master, node: str) -> set[str]:
    """Return what a node has at the master."""
    state = master.call("getSystemState")[2]
    words = zip(("pub", "sub", "srv"), state, strict=True)
    return {f"{word} {name}" for word, part in words for name, nodes in part if f"/{node}" in nodes}
