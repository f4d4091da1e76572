"""Differential tests of the commands: the same running system, asked by the stock tool and by ours (L25-L83, N11).

Exit code, stdout and stderr must be the same but for what differs from run to run: process ids, ports, times. Intended
differences are the subject of tests of their own, at the end.

Feature: commands print what the stock tools print -- about 1,600 command lines, both tools side by side:
    [interop/commands.md](interop/commands.md)
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from harness import SOURCE, Master, Process, our_tools, stock_tools, without_thread_errors, write_tool

OWN_MASTER = True

DEADLINE = 30.0

STOCK_SYSTEM = """
import rospy
from std_msgs.msg import String
from std_srvs.srv import Empty, EmptyResponse, SetBool, SetBoolResponse
from nav_msgs.srv import GetPlan, GetPlanResponse
from sensor_msgs.msg import JointState
from geometry_msgs.msg import Pose, PoseArray, PoseStamped
rospy.init_node("subject")
latched = dict(queue_size=10, latch=True)
word = rospy.Publisher("word", String, **latched); word.publish("hello \\u00fc")
joints = JointState(); joints.header.frame_id = "base"; joints.header.stamp = rospy.Time(5, 7)
joints.name = ["a", "b"]; joints.position = [1.0, 2.5]
state = rospy.Publisher("state", JointState, **latched); state.publish(joints)
poses = PoseArray(); poses.header.frame_id = "map"; poses.header.stamp = rospy.Time(9, 1)
poses.poses = [Pose() for _ in range(3)]
for number, pose in enumerate(poses.poses): pose.position.x = number; pose.position.y = 0.1 * number
path = rospy.Publisher("path", PoseArray, **latched); path.publish(poses)
stamped = PoseStamped(); stamped.header.stamp = rospy.Time(77, 5); stamped.header.frame_id = "map"
stamped.pose.position.x = -0.1; stamped.pose.orientation.w = 1e-9
pose = rospy.Publisher("pose", PoseStamped, **latched); pose.publish(stamped)
listener = rospy.Subscriber("unheard", String, lambda m: None)
def flip(request):
    if not request.data: raise ValueError("nope")
    return SetBoolResponse(True, "ok %s" % request.data)
services = [rospy.Service("~flip", SetBool, flip), rospy.Service("empty", Empty, lambda r: EmptyResponse())]
services += [rospy.Service("plan", GetPlan, lambda r: GetPlanResponse())]
print("ready", flush=True)
rospy.spin()
"""

OUR_SYSTEM = """
import pyros1
from pyros1.msgs.std_msgs.msg import String
from pyros1.msgs.std_srvs.srv import Empty, EmptyResponse, SetBool, SetBoolResponse
from pyros1.msgs.nav_msgs.srv import GetPlan, GetPlanResponse
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.msgs.geometry_msgs.msg import Pose, PoseArray, PoseStamped
node = pyros1.Node("subject")
def latched(topic, message):
    publisher = node.advertise(topic, type(message), queue_size=10, latch=True); publisher.publish(message)
latched("word", String("hello \\u00fc"))
joints = JointState(name=["a", "b"], position=[1.0, 2.5]); joints.header.frame_id = "base"
joints.header.stamp = pyros1.Time(5, 7)
latched("state", joints)
poses = PoseArray(poses=[Pose() for _ in range(3)])
poses.header.frame_id = "map"; poses.header.stamp = pyros1.Time(9, 1)
for number, pose in enumerate(poses.poses): pose.position.x = number; pose.position.y = 0.1 * number
latched("path", poses)
stamped = PoseStamped(); stamped.header.stamp = pyros1.Time(77, 5); stamped.header.frame_id = "map"
stamped.pose.position.x = -0.1; stamped.pose.orientation.w = 1e-9
latched("pose", stamped)
node.subscribe("unheard", String, lambda m: None)
def flip(request):
    if not request.data: raise ValueError("nope")
    return SetBoolResponse(True, "ok %s" % request.data)
node.advertise_service("~flip", SetBool, flip)
node.advertise_service("empty", Empty, lambda r: EmptyResponse())
node.advertise_service("plan", GetPlan, lambda r: GetPlanResponse())
print("ready", flush=True)
node.spin()
"""

Answer = tuple[int, str, str]


@pytest.fixture(scope="module")
def system(master: Master) -> Iterator[Master]:
    """Stock nodes under the stock master, ours under ours."""
    if master.kind == "stock":
        command = ["/usr/bin/python3", "-c", STOCK_SYSTEM]
        environ = dict(master.environ())
    else:
        command = [sys.executable, "-c", OUR_SYSTEM]
        environ = {**master.environ(), "PYTHONPATH": str(SOURCE)}
    process = Process(command, environ, "subject")
    process.wait_line("^ready$")
    yield master
    process.close()


@pytest.fixture(scope="module")
def tools(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with our program under the stock tools' names, so that usage texts too can be compared."""
    folder = tmp_path_factory.mktemp("tools")
    for name in ("rostopic", "rosnode", "rosservice", "rosparam"):
        write_tool(folder, name)
    return folder


def ask(master: Master, program: str, words: list[str], stdin: str = "", **environ: str) -> Answer:
    variables = {**master.environ(), **environ}
    tools = stock_tools() if program.startswith("/usr/bin/") else our_tools()
    return tools.ask([program, *words], variables, stdin=stdin, timeout=DEADLINE)


_VARYING = [
    (re.compile(r"time=[0-9.]+ms"), "time=Nms"),
    (re.compile(r"average: [0-9.]+ms"), "average: Nms"),
    (re.compile(r"^\d{18,19},", re.M), "STAMP,"),
    # Stock says so where rosdep is installed but was never set up.
    (re.compile(r"^the rosdep view is empty: .*\n", re.M), ""),
    # A latching rospy publisher counts on with each late subscriber.
    (re.compile(r"seq: +\d+"), "seq: N"),
    (re.compile(r"^(\w+),\d+,(\d+,)?(?=base|map|1\.0)", re.M), r"\1,N,\2"),
    (re.compile(r"^(5000000007),\d+,", re.M), r"\1,N,"),
    (re.compile(r"\(\d+ - ([0-9.a-z]+):\d+\) \[\d+\]"), r"(N - \1:N) [N]"),
]


def normal(text: str) -> str:
    for pattern, replacement in _VARYING:
        text = pattern.sub(replacement, text)
    return text


def compare(system: Master, tools: Path, words: list[str], stdin: str = "", **environ: str) -> None:
    programs = ["/usr/bin/" + words[0], str(tools / words[0])]
    with ThreadPoolExecutor(2) as both:  # most of a tool's time is waiting
        stock, ours = both.map(lambda program: ask(system, program, words[1:], stdin, **environ), programs)
    expected = [stock[0], normal(stock[1]), normal(without_thread_errors(stock[2]))]
    assert [ours[0], normal(ours[1]), normal(ours[2])] == expected


QUESTIONS = """
rostopic
rostopic nonsense
rostopic list
rostopic list -v
rostopic list -p
rostopic list -s
rostopic list -p -s
rostopic list -v -p
rostopic list -v -s
rostopic list /pose
rostopic list pose -v
rostopic list /nope
rostopic list a b
rostopic list --host
rostopic list --host -v
rostopic list --host -p
rostopic info word
rostopic info /unheard
rostopic info /rosout
rostopic info /nope
rostopic info
rostopic info a b
rostopic info -h
rostopic type word
rostopic type /pose/header/stamp
rostopic type /pose/header/stamp/secs
rostopic type /path/poses
rostopic type /pose/nofield
rostopic type /nope
rostopic find std_msgs/String
rostopic find no/Such
rostopic find
rostopic find a b
rostopic find -h
rostopic echo
rostopic echo a b
rostopic echo -n x /word
rostopic echo -w x /word
rostopic echo -n 1 /word
rostopic echo -n 1 /word/data
rostopic echo -n 1 /word/data[0]
rostopic echo -n 1 /word/data[1:3]
rostopic echo -n 1 /pose
rostopic echo -n 1 /pose/pose/position/x
rostopic echo -n 1 /pose/header/stamp
rostopic echo -n 1 /pose/header/stamp/secs
rostopic echo -n 1 /pose/header/frame_id
rostopic echo -n 1 /state
rostopic echo -n 1 /state/name
rostopic echo -n 1 /state/name[1]
rostopic echo -n 1 /state/position
rostopic echo -n 1 /state/position[-1]
rostopic echo -n 1 /state/position[0:1]
rostopic echo -n 1 /path/poses
rostopic echo -n 1 /path/poses[1]
rostopic echo -n 1 /path/poses[1]/position
rostopic echo -n 1 /path/poses[0:2]/position
rostopic echo -n 1 /path/poses[::2]/position/x
rostopic echo -n 1 --noarr /state
rostopic echo -n 1 --nostr /state
rostopic echo -n 1 --noarr --nostr /state
rostopic echo -n 1 --noarr /path
rostopic echo -n 1 --nostr /word/data
rostopic echo -n 1 --noarr /state/position
rostopic echo -n 1 -p /word
rostopic echo -n 1 -p /pose
rostopic echo -n 1 -p /state
rostopic echo -n 1 -p /path
rostopic echo -n 1 -p --noarr /state
rostopic echo -n 1 -p --nostr /state
rostopic echo -n 1 -p /path/poses[0:2]/position
rostopic echo -n 1 -p /state/position
rostopic echo -n 1 -p /pose/pose/position/x
rostopic echo -n 1 -w 8 /pose
rostopic echo -n 1 -w 8 /state
rostopic echo -n 1 -w 3 /pose/pose/position/x
rostopic echo -n 1 -c /word
rostopic echo -n 1 --filter m.data.startswith('hello') /word
rostopic echo -n 1 --filter m.pose.position.x<0 /pose
rostopic hz
rostopic hz -w x /word
rostopic bw
rostopic bw a b
rostopic bw -w x /word
rostopic pub
rostopic pub /x
rostopic pub -r 0 /x std_msgs/String a
rostopic pub -r x /x std_msgs/String a
rostopic pub -r 2 -1 /x std_msgs/String a
rostopic pub -1 /x Nope a
rostopic pub -1 /x std_msgs/Nope a
rostopic pub -1 /x std_msgs/String a b
rostopic pub -1 /x std_msgs/String {nofield:\u00a01}
rostopic pub -1 /x geometry_msgs/PoseStamped auto
rostopic pub -f nofile /x std_msgs/String
rostopic pub -f nofile /x std_msgs/String a
rosnode
rosnode nonsense
rosnode -h
rosnode --help
rosnode list
rosnode list -u
rosnode list -a
rosnode list /subject
rosnode list /nope
rosnode list a b
rosnode info -q subject
rosnode info -q /nope
rosnode info /nope
rosnode info subject
rosnode info
rosnode info -h
rosnode ping -c 1 subject
rosnode ping /nope
rosnode ping a b
rosnode ping
rosnode ping -h
rosnode machine
rosnode machine localhost
rosnode machine a b
rosnode kill /nope
rosnode kill -h
rosnode cleanup
rosnode cleanup -h
rosnode list -h
rosservice
rosservice nonsense
rosservice list
rosservice list -n
rosservice list /subject
rosservice list /subject/flip -n
rosservice list /nope
rosservice list a b
rosservice list -h
rosservice info /subject/flip
rosservice info empty
rosservice info /nope
rosservice info
rosservice info a b
rosservice type /subject/flip
rosservice type /nope
rosservice type
rosservice type a b
rosservice uri /subject/flip
rosservice uri /nope
rosservice uri
rosservice node /subject/flip
rosservice node /nope
rosservice args /subject/flip
rosservice args /empty
rosservice args /plan
rosservice info /plan
rosservice call /plan 1 2
rosservice args /subject/set_logger_level
rosservice args /nope
rosservice find std_srvs/SetBool
rosservice find no/Such
rosservice find
rosservice call
rosservice call /subject/flip true
rosservice call -v /subject/flip true
rosservice call /subject/flip data:\u00a0true
rosservice call -v /subject/flip {data:\u00a0true}
rosservice call /subject/flip false
rosservice call /subject/flip 7
rosservice call /subject/flip 1 2
rosservice call /subject/flip {dota:\u00a01}
rosservice call --wait /subject/flip true
rosservice call /empty
rosservice call -v /empty
rosservice call /empty 1
rosservice call /nope 1
rosservice call -h
rosparam
rosparam nonsense
rosparam -h
rosparam list a b
rosparam list /nope
rosparam get
rosparam get a b
rosparam get /nope
rosparam get -h
rosparam set
rosparam set a
rosparam set a b c
rosparam set a -
rosparam set a -- -
rosparam set a -- --
rosparam set -h
rosparam set /t/bad {1:\u00a02}
rosparam set -t nofile /t/text
rosparam load
rosparam load nofile
rosparam load a b c
rosparam load -h
rosparam dump a b c
rosparam dump -h
rosparam delete
rosparam delete a b
rosparam delete /nope
rosparam delete -h
rosparam list -h
"""


@pytest.mark.parametrize("line", QUESTIONS.strip().split("\n"))
def test_a_question_is_answered_as_by_the_stock_tool(system: Master, tools: Path, line: str) -> None:
    # No-break spaces stand for spaces inside an argument.
    compare(system, tools, [word.replace("\u00a0", " ") for word in line.split(" ")])


@pytest.mark.parametrize(
    "value",
    [
        "1",
        "-5",
        "2.50",
        "1e3",
        "hello",
        "'1'",
        "",
        "yes",
        "[]",
        "[1, 2.5, x, {k: v}]",
        "deg(90)",
        "grüße",
        "a: b",
        "'a: b'",
        "{p: 1, q: {r: s, t: [[1, 2], [3]]}, u: 'l1'}",
        '"l1\\nl2"',
        "0x1F",
        "010",
        "1_000",
        ".5",
        "'yes'",
        "'#x'",
        "x y z",
    ],
)
def test_a_parameter_is_set_and_shown_as_by_rosparam(system: Master, tools: Path, value: str) -> None:
    """L80, L81, L84: what one tool sets, both show the same; the other way round too."""
    setters = {"/usr/bin/rosparam": "/t_cli/stock", str(tools / "rosparam"): "/t_cli/ours"}
    said = []
    for program, name in setters.items():
        code, out, err = ask(system, program, ["set", "-v", name, value])
        said.append((code, out.replace(name, "NAME"), err))
        compare(system, tools, ["rosparam", "get", name])
        compare(system, tools, ["rosparam", "get", "-p", name])
        compare(system, tools, ["rosparam", "get", "-v", name])
    assert said[1] == said[0]
    compare(system, tools, ["rosparam", "list", "/t_cli"])
    compare(system, tools, ["rosparam", "dump", "-v"])
    for program, name in setters.items():
        assert ask(system, program, ["delete", "-v", name]) == (0, f"deleted parameter [{name}]\n", "")


def test_parameters_are_loaded_and_dumped_as_by_rosparam(system: Master, tools: Path, tmp_path: Path) -> None:
    """L82"""
    file = tmp_path / "in.yaml"
    file.write_text("x: 1\ny: {z: [1, 2], w: 's'}\n---\n_ns: other\nq: true\n")
    text = file.read_text()
    for words in (
        ["load", "-v", str(file), "/t_load"],
        ["load", "-v", "-", "t_load/sub"],
        ["load", str(file), "/t_load"],
    ):
        compare(system, tools, ["rosparam", *words], text)
    compare(system, tools, ["rosparam", "get", "/t_load"])
    dumps = []
    for program, name in (("/usr/bin/rosparam", "stock.yaml"), (str(tools / "rosparam"), "ours.yaml")):
        code, out, err = ask(system, program, ["dump", "-v", str(tmp_path / name), "/t_load"])
        dumps.append((code, out.replace(name, "FILE"), err, (tmp_path / name).read_text()))
    assert dumps[1] == dumps[0]
    assert ask(system, str(tools / "rosparam"), ["delete", "/t_load"])[0] == 0


@pytest.mark.parametrize(
    "words",
    [
        ["rosservice", "list"],
        ["rosservice", "type", "flip"],
        ["rosnode", "list"],
        ["rostopic", "list"],
        ["rosparam", "list"],
    ],
)
def test_the_namespace_counts_as_for_the_stock_tool(system: Master, tools: Path, words: list[str]) -> None:
    """N11"""
    compare(system, tools, words, ROS_NAMESPACE="/subject")
    if words[0] not in ("rosnode", "rosparam"):  # those take the argument for a namespace instead (a stock defect)
        compare(system, tools, [*words, "__ns:=/subject"])
        compare(system, tools, [*words, "a:=b"])


def test_a_service_is_called_with_documents_from_stdin(system: Master, tools: Path) -> None:
    """L78"""
    compare(system, tools, ["rosservice", "call", "-v", "/subject/flip"], "data: true\n---\ndata: true\n---\n")


@pytest.mark.parametrize("publisher", ["stock", "ours"])
def test_echo_of_each_shows_what_pub_of_each_publishes(system: Master, tools: Path, publisher: str) -> None:
    """L67, L68: pub -r, shown by both echoes."""
    program = "/usr/bin/rostopic" if publisher == "stock" else str(tools / "rostopic")
    words = ["pub", "-r", "20", "/t_pub", "geometry_msgs/Twist", "{linear: {x: 1.5}, angular: [1, 2, -3]}"]
    process = Process([program, *words], dict(system.environ()), "pub")
    try:
        answers = []
        for echo in ("/usr/bin/rostopic", str(tools / "rostopic")):
            code, out, _ = ask(system, echo, ["echo", "-n", "2", "/t_pub"])  # stderr: it may have to wait first
            answers.append((code, out))
    finally:
        process.close()
    assert answers[0] == answers[1]
    assert answers[0][1].count("x: 1.5") == 2


def test_pub_once_says_what_the_stock_tool_says(system: Master, tools: Path) -> None:
    """L67"""
    compare(system, tools, ["rostopic", "pub", "-1", "-v", "/t_once", "std_msgs/Float64", "--", "-2.5"])


def test_ctrl_c_ends_echo_and_pub_quietly(system: Master, tools: Path) -> None:
    """L04"""
    for words in (["echo", "/word"], ["pub", "/t_end", "std_msgs/String", "x"], ["hz", "/word"]):
        process = Process([str(tools / "rostopic"), *words], dict(system.environ()), words[0])
        process.wait_line("data|latching|subscribed")
        process.signal(2)
        assert process.wait() == 0, process.transcript()
        process.close()
        assert "Traceback" not in process.transcript()


def test_a_topic_of_a_package_that_is_installed_nowhere_is_shown(system: Master, tools: Path) -> None:
    """The definition in the connection header is enough, nested types included; no stock tool can do that.

    Feature: topics of types that are not installed -- the definition comes from the connection header
    """
    nested = "foo_msgs/Inner[] inners\nstring name\n" + "=" * 80 + "\nMSG: foo_msgs/Inner\nfloat32 x\ntime at\n"
    code = f"""
import pyros1
from pyros1.msgs import from_definition
cls = from_definition("foo_msgs/Outer", {nested!r})
message = cls(name="n")
inner = cls._classes["foo_msgs/Inner"]
message.inners = [inner(1.5, pyros1.Time(3, 4)), inner(2.5, pyros1.Time(5, 6))]
node = pyros1.Node("foreign")
publisher = node.advertise("foreign", cls, latch=True); publisher.publish(message)
print("ready", flush=True)
node.spin()
"""
    process = Process([sys.executable, "-c", code], {**system.environ(), "PYTHONPATH": str(SOURCE)}, "foreign")
    try:
        process.wait_line("^ready$")
        shown = ask(system, str(tools / "rostopic"), ["echo", "-n", "1", "/foreign"])
        part = ask(system, str(tools / "rostopic"), ["echo", "-n", "1", "/foreign/inners[:]/x"])
        plot = ask(system, str(tools / "rostopic"), ["echo", "-n", "1", "-p", "/foreign/inners[1]"])
    finally:
        process.close()
    expected = "inners: \n  - \n    x: 1.5\n    at: \n      secs: 3\n      nsecs:         4\n"
    expected += "  - \n    x: 2.5\n    at: \n      secs: 5\n      nsecs:         6\n" + 'name: "n"\n---\n'
    assert shown == (0, expected, "")
    assert part == (0, "[1.5, 2.5]\n---\n", "")
    assert normal(plot[1]) == "%time,field.x,field.at\nSTAMP,2.5,5000000006\n"


@pytest.mark.parametrize("tool", ["rostopic", "rosnode", "rosservice", "rosparam"])
def test_without_a_master_the_stock_line_and_code_appear(system: Master, tools: Path, tool: str) -> None:
    """L03. Intended difference: below the line ours says where, why, and what to do."""
    away = "http://localhost:9/"
    stock = ask(system, "/usr/bin/" + tool, ["list"], ROS_MASTER_URI=away)
    code, out, err = ask(system, str(tools / tool), ["list"], ROS_MASTER_URI=away)
    assert (code, out) == stock[:2] and err.startswith(f"{stock[2]}no answer from the master at {away} (")


def test_a_wrong_request_is_told_with_its_value(system: Master, tools: Path) -> None:
    """Intended difference: ours also says what was given."""
    words = ["call", "/subject/flip", "foo"]
    code, out, err = ask(system, "/usr/bin/rosservice", words)
    more = err.replace(" field data is not a bool", " service [/subject/flip]: field data is not a bool, but str 'foo'")
    assert ask(system, str(tools / "rosservice"), words) == (code, out, more) and more != err


def test_wrong_values_are_told_at_once(system: Master, tools: Path) -> None:
    """Intended difference from L69 and L85: no traceback, and not only when a subscriber comes."""
    code, out, err = ask(system, str(tools / "rostopic"), ["pub", "-1", "/t_bad", "std_msgs/Int32", "hello"])
    assert (code, out, err.splitlines()[0]) == (1, "", "ERROR: field data must be an integer type, not str 'hello'")
    code, out, err = ask(system, str(tools / "rosparam"), ["set", "/t_bad", "5000000000"])
    assert (code, out) == (1, "") and err.startswith("ERROR: ") and "Traceback" not in err
