"""Stock's nodes of rostest (L186), scripts and node names of rosbag (L146, L05), nodes of tf (L199), beside ours."""

from __future__ import annotations

import os
import queue
import re
import subprocess
import sys
import xml.etree.ElementTree
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from harness import SOURCE, Master, stock_tools, until

from pyros1.msgs import load_message
from pyros1.node import Node
from pyros1.tf import BufferClient, StaticTransformBroadcaster, TransformBroadcaster, TransformException

MASTERS = ("ours",)  # stock's tools and ours are compared, whatever the master
STOCK_PYTHON = "/usr/bin/python3"
MAKER = Path(__file__).resolve().parents[1] / "peers" / "stock_bags.py"
ASKING = MAKER.with_name("tf_asking.py")
OWN = SOURCE / "pyros1" / "packages"
PROGRAM = ["-m", "pyros1", "tf"]
LOGGED = re.compile(r"\S*\[(INFO|WARN|ERROR)\]")

pytestmark = pytest.mark.ours_only

# rostest --------------------------------------------------------------------------------------------------------------

PACKAGE = """<package format="2"><name>tested</name><version>1.0.0</version><description>Tests.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
TALK = """#!/usr/bin/python3
import rospy
from std_msgs.msg import String
rospy.init_node("talk")
publisher, rate = rospy.Publisher("/beat", String, queue_size=1), rospy.Rate(20)
while not rospy.is_shutdown():
    publisher.publish("x")
    rate.sleep()
"""
FILE = """<launch><node pkg="tested" type="talk" name="talk"/>
<test pkg="rostest" type="hztest" test-name="hz"><rosparam>
  {topic: beat, hz: 20.0, hzerror: 19.0, test_duration: 4.0, wait_time: 40}</rosparam></test>
<test pkg="rostest" type="hztest" test-name="hz_wrong"><rosparam>
  {topic: beat, hz: x, test_duration: 1.0}</rosparam></test>
<test pkg="rostest" type="publishtest" test-name="publish"><rosparam>
  {topics: [{name: beat, timeout: 40}, {name: silence, timeout: 0.5}]}</rosparam></test>
<test pkg="rostest" type="publishtest" test-name="publish_nothing"/>
<test pkg="rostest" type="advertisetest" test-name="advertise"><rosparam>
  {topics: [{name: /beat, timeout: 40, type: std_msgs/Bool}], services: [{name: /talk/get_loggers}]}</rosparam></test>
</launch>"""


def test_the_nodes_of_rostest_l186(tmp_path: Path) -> None:
    """One file, with good and with failing tests, under each rostest with its own nodes.

    Feature: .test files with hztest, paramtest, publishtest, advertisetest run -- without ROS
    """
    package = tmp_path / "tested"
    (package / "test").mkdir(parents=True)
    (package / "package.xml").write_text(PACKAGE)
    (package / "test" / "all.test").write_text(FILE)
    (package / "talk").write_text(TALK)
    (package / "talk").chmod(0o755)
    commands = {"stock": ["rostest"], "ours": [sys.executable, "-m", "pyros1", "test"]}

    def run(who: str) -> tuple[int, dict[str, list[str]], list[str]]:
        environ = {
            **os.environ,
            "ROS_HOME": str(tmp_path / who),
            "ROS_HOSTNAME": "localhost",
            "PATH": f"/usr/bin:{os.environ['PATH']}",  # stock's nodes say ``env python3``
            "ROS_PACKAGE_PATH": f"{package}:{OWN if who == 'ours' else '/usr/share'}",
            "PYTHONPATH": str(SOURCE) if who == "ours" else "",
        }
        done = subprocess.run(
            [*commands[who], "tested", "all.test"],
            env=environ,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        folder = tmp_path / who / "test_results"
        files = {str(path.relative_to(folder)): cases(path) for path in sorted(folder.rglob("*.xml"))}
        return done.returncode, files, re.findall(r"(?:RESULT|TESTS|ERRORS|FAILURES): \w+", done.stdout)

    with ThreadPoolExecutor() as pool:
        stock, ours = pool.map(run, commands)
    assert ours == stock
    assert ours[0] == 1
    assert ours[2] == ["RESULT: FAIL", "TESTS: 5", "ERRORS: 1", "FAILURES: 3"]


def cases(path: Path) -> list[str]:
    """Class and name of a file's test cases, and the tags in them."""
    root = xml.etree.ElementTree.parse(path).getroot()
    return [
        " ".join([str(case.get("classname")), str(case.get("name")), *sorted(child.tag for child in case)])
        for case in root.iter("testcase")
    ]


# rosbag ---------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags")
    code, _, err = stock_tools().ask([str(MAKER), str(folder)], os.environ)
    assert code == 0, err
    return folder


SCRIPTS = {
    "bagsort.py mixed.bag OUT": "filter mixed.bag OUT True",
    "fastrebag.py mixed.bag OUT": "merge OUT mixed.bag",
    "topic_renamer.py /number mixed.bag /count OUT": "rename-topic mixed.bag OUT /number /count",
    "fixbag.py mixed.bag OUT": "fix mixed.bag OUT",
}


@pytest.mark.parametrize("line", SCRIPTS)
def test_verbs_do_what_the_scripts_of_rosbag_do_l146(bags: Path, line: str) -> None:
    made = {}
    for who, words in (("stock", line), ("ours", SCRIPTS[line])):
        first, *rest = words.replace("OUT", f"{who}.bag").split()
        command = [STOCK_PYTHON, f"/usr/lib/rosbag/{first}"]
        if who == "ours":
            command = [sys.executable, "-m", "pyros1", "bag", first]
        done = subprocess.run(
            [*command, *rest],
            cwd=bags,
            env={**os.environ, "ROS_HOME": str(bags), **({"PYTHONPATH": str(SOURCE)} if who == "ours" else {})},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        made[who] = dump(bags / f"{who}.bag")
    assert made["ours"] == made["stock"]


def dump(path: Path) -> list[str]:
    """All messages of a bag as stock reads them, sorted; stock's scripts lose the connection headers."""
    code, out, err = stock_tools().ask([str(MAKER), "dump", str(path)], os.environ)
    assert code == 0, err
    return sorted(line.partition(" [")[0] for line in out.splitlines())


def test_names_of_recorder_and_player_l05(launcher: Master, bags: Path, tmp_path: Path) -> None:
    def known() -> set[str]:
        return {name for table in launcher.call("getSystemState")[2] for _, names in table for name in names}

    for who in ("stock", "ours"):
        program = ["rosbag"] if who == "stock" else [sys.executable, "-m", "pyros1", "bag"]
        before = known()
        started = [
            launcher.run([*program, *words], python=who, TERM="dumb")
            for words in (["record", "-O", str(tmp_path / who), "/x"], ["play", "--pause", str(bags / "plain.bag")])
        ]
        until(lambda before=before: len(known() - before) == 2, f"the nodes of {who}")
        names = sorted(re.sub(r"\d{19}", "NS", name) for name in known() - before)
        for process in started:
            process.close()
        assert names == ["/play_NS", "/record_NS"], who


# tf -------------------------------------------------------------------------------------------------------------------

QUESTIONS = [("map", "base"), ("base", "lidar"), ("map", "none"), ("map", "island"), ("map", ""), ("map", "/base")]


@pytest.fixture
def node(launcher: Master) -> Iterator[Node]:
    node = Node("gaps", argv=[], environ=launcher.environ("ours"), handle_signals=False)
    yield node
    node.shutdown()


def stamped(parent: str, child: str, node: Node, x: float) -> Any:
    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, node.now()
    message.transform.translation.x = x
    message.transform.rotation.w = 1.0
    return message


def test_buffer_servers_l199(launcher: Master, node: Node) -> None:
    """Stock's client gets the same answers from stock's server and ours; ours does, too.

    Feature: lookups in other nodes' buffers, through actions -- `pyros1 tf buffer_server`,
        `pyros1.tf.BufferServer`, `BufferClient`
    """
    StaticTransformBroadcaster(node).send_transform(
        [stamped("map", "base", node, 1.5), stamped("base", "lidar", node, 0.5), stamped("other", "island", node, 0.0)]
    )
    servers = {"/stock": ["/usr/lib/tf2_ros/buffer_server"], "/ours": [sys.executable, *PROGRAM, "buffer_server"]}
    topics = ("goal", "cancel", "status", "feedback", "result")
    asking = []
    for action, command in servers.items():
        renamed = [f"/tf2_buffer_server/{topic}:={action}/{topic}" for topic in topics]
        python = action.strip("/")
        launcher.run([*command, f"__name:=server_{python}", *renamed], python=python)
        asking.append(launcher.run([STOCK_PYTHON, str(ASKING), action], label=f"asking {action}"))
    assert [process.wait(60) for process in asking] == [0, 0]
    stock, ours = ([line for line in process.lines if not LOGGED.match(line)] for process in asking)
    assert ours == stock
    assert len(stock) == 13
    answers = []
    for action in servers:
        client = BufferClient(node, action)
        answers.append([told(client, question) for question in QUESTIONS])
    assert answers[1] == answers[0]


def told(client: BufferClient, question: tuple[str, str]) -> str:
    try:
        return str(client.lookup_transform(*question))
    except TransformException as error:
        return f"{type(error).__name__} {error}"


def test_change_notifiers_l199(launcher: Master, node: Node) -> None:
    """Both tell of moves that are far enough."""
    watched = [{"source_frame": "arm", "target_frame": "base", "angular_update_distance": 1.0}]
    moving, positions = TransformBroadcaster(node), [1.0]
    commands = {"stock": ["/usr/lib/tf/tf_change_notifier"], "ours": [sys.executable, *PROGRAM, "change_notifier"]}
    changes: dict[str, queue.Queue[Any]] = {}
    for who, command in commands.items():
        node.params[f"/notifier_{who}/frame_pairs"] = watched
        changes[who] = queue.Queue()
        node.subscribe(f"/changes_{who}", "tf/tfMessage", changes[who].put)
        launcher.run([*command, f"__name:=notifier_{who}", f"tf_changes:=/changes_{who}"], python=who)
    node.timer(0.02, lambda _: moving.send_transform(stamped("base", "arm", node, positions[-1])))
    said: dict[str, list[tuple[str, str, float]]] = {"stock": [], "ours": []}
    # Where stock begins is what the memory holds: it may not tell of the first position.
    until(lambda: not changes["ours"].empty(), "the first change")
    for place in (3.0, 4.0):
        positions.append(place)
        for who, came in changes.items():
            while not said[who] or said[who][-1][2] != place:
                (each,) = came.get(timeout=30).transforms
                said[who].append((each.header.frame_id, each.child_frame_id, each.transform.translation.x))
    assert said["ours"] == [("/base", "/arm", place) for place in (1.0, 3.0, 4.0)]
    assert said["stock"][-2:] == said["ours"][-2:]
