"""pyros1 tf against a master and nodes in this process; beside stock's tools in interop/tf/test_tf_tools.py."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import xml.dom.minidom
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.commands.tf._drawing import Frame, find_roots_and_children, format_tree, render_dot, render_svg
from pyros1.cli.main import entry
from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import PackageNotFoundError
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.node import Node
from pyros1.tf import Buffer, StaticTransformBroadcaster, TransformBroadcaster, TransformListener

SOURCES = Path(__file__).resolve().parents[4] / "src"
Make = Callable[..., Node]
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)
    monkeypatch.chdir(tmp_path)
    return partial(call_main, entry, "pyros1", "tf")


@pytest.fixture
def eventually(run: Run) -> Run:
    """Runs a command again until it succeeds and shows all three frames: on a busy machine links take their time."""

    def call(*words: str) -> tuple[int, str, str]:
        for _ in range(30):
            done = run(*words)
            if done[0] == 0 and ("echo" in words[0] or all(word in done[1] for word in ("base", "odom", "map"))):
                break
        return done

    return call


def stamped(parent: str, child: str, stamp: Time, x: float = 0.0) -> Any:
    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, stamp
    message.transform.translation.x = x
    message.transform.rotation.w = 1.0
    return message


@pytest.fixture
def robot(make_node: Make) -> Node:
    """map -> odom, sent 50 times a second; odom -> base, static."""
    node = make_node("robot", rosout=False)
    StaticTransformBroadcaster(node).send_transform(stamped("odom", "base", node.now(), 0.5))
    moving = TransformBroadcaster(node)
    node.timer(0.02, lambda _: moving.send_transform(stamped("map", "odom", node.now(), 1.0)))
    return node


@pytest.fixture
def program(environ: dict[str, str]) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts programs with this master; they end on SIGINT with the test."""
    children: list[subprocess.Popen[str]] = []

    def start(*words: str, **extra: str) -> subprocess.Popen[str]:
        env = {**os.environ, **environ, "PYTHONPATH": str(SOURCES), **extra}
        child = subprocess.Popen(
            [sys.executable, *words], env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        children.append(child)
        return child

    yield start
    for child in children:
        child.terminate()
    for child in children:
        child.communicate(timeout=20)


# Echo -----------------------------------------------------------------------------------------------------------------


def test_echo(eventually: Run, robot: Node) -> None:
    """L195"""
    code, out, _ = eventually("echo", "map", "base", "-l", "1")
    assert code == 0
    lines = out.splitlines()
    assert lines[0].startswith("At time ") and len(lines[0].partition(".")[2]) == 3
    assert lines[1:] == [
        "- Translation: [1.500, 0.000, 0.000]",
        "- Rotation: in Quaternion [0.000, 0.000, 0.000, 1.000]",
        "            in RPY (radian) [0.000, -0.000, 0.000]",
        "            in RPY (degree) [0.000, -0.000, 0.000]",
    ]
    assert "- Translation: [-1.5, 0.0, 0.0]\n" in eventually("tf_echo", "/base", "/map", "100", "-l", "3", "-p", "1")[1]
    assert "- Translation: [1.50000, " in eventually("echo", "map", "base", "-l", "1", "_precision:=5")[1]
    assert eventually("echo", "map", "base", "-l", "1", "-o", "-0.05")[0] == 0
    assert "(current time " in eventually("echo", "map", "base", "-l", "1", "--tf2")[1]


def test_echo_as_json(run: Run, eventually: Run, robot: Node) -> None:
    code, out, _ = eventually("echo", "map", "base", "-r", "100", "-l", "2", "--json")
    rows = [json.loads(line) for line in out.splitlines()]
    assert code == 0 and len(rows) == 2
    assert (rows[0]["frame_id"], rows[0]["child_frame_id"], rows[0]["translation"]["x"]) == ("map", "base", 1.5)
    assert rows[0]["rotation"]["w"] == 1.0 and set(rows[0]["rpy"]) == {"roll", "pitch", "yaw"}
    code, out, _ = run("echo", "map", "bose", "-l", "1", "--json")
    assert code == 1 and json.loads(out)["error"] == "LookupException"


@pytest.mark.slow
def test_echo_of_what_is_not_there(run: Run, robot: Node, make_node: Make) -> None:
    code, out, err = run("echo", "map", "bose", "-r", "50", "-l", "2")
    assert code == 1 and out.startswith("Failure at ") and "\nThe current list of frames is:\nFrame " in out
    assert out.count('Exception thrown:"bose" passed to lookupTransform argument source_frame does not exist. \n') == 2
    assert err.count("Unknown frame 'bose' (did you mean 'base'?); known frames: base, map, odom") == 1
    StaticTransformBroadcaster(make_node("isle")).send_transform(stamped("isle", "palm", Time(1)))
    code, _, err = run("echo", "palm", "base", "-r", "50", "-l", "1")
    assert code == 1 and "with the roots 'isle' and 'map'" in err
    code, out, _ = run("echo", "map", "base", "-r", "50", "-l", "1", "-t", "5")
    assert code == 1 and "extrapolation" in out


def test_nothing_publishes(run: Run, make_node: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.cli.commands.tf.echo.INITIAL_TIMEOUT", 0.1)
    assert "No node publishes /tf or /tf_static" in run("echo", "map", "base", "-r", "50", "-l", "1")[2]
    assert (
        "No node publishes /transforms or" in run("echo", "map", "base", "-r", "50", "-l", "1", "/tf:=/transforms")[2]
    )
    make_node("silent").advertise("/tf", "tf2_msgs/TFMessage")
    code, _, err = run("tree", "-t", "0.1")
    assert code == 1 and "No transform received yet from /silent: is it running?" in err


@pytest.mark.slow
def test_simulated_time_that_stands_still(program: Callable[..., Any], make_node: Make) -> None:
    maker = make_node("simulator")
    maker.params["/use_sim_time"] = True
    child = program("-m", "pyros1", "tf", "echo", "map", "base")
    assert "no /clock messages arrive" in child.stdout.readline()
    clock = maker.advertise("/clock", "rosgraph_msgs/Clock")
    tick: Any = load_message("rosgraph_msgs/Clock")
    seconds = iter(range(5, 10_000))
    maker.timer(0.02, lambda _: clock.publish(tick(Time(next(seconds)))))
    assert child.stdout.readline().startswith("Failure at ")


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 64, "Commands:"),
        (["ecco"], 64, "did you mean 'echo'?"),
        (["echo"], 255, "Usage: pyros1 tf echo"),
        (["echo", "a"], 255, "Usage: pyros1 tf echo"),
        (["echo", "a", "b", "c", "d"], 255, "Usage: pyros1 tf echo"),
        (["echo", "a", "b", "fast"], 2, "the rate must be a positive number, not 'fast'"),
        (["echo", "a", "b", "-l", "x"], 2, "the limit must be a whole number"),
        (["echo", "a", "b", "-t", "nan"], 2, "the time must be a number"),
        (["echo", "-h"], 0, "Examples:"),
        (["monitor", "a"], 2, "two"),
        (["tree", "x"], 2, "unexpected argument 'x'"),
        (["view_frames", "f.svg"], 2, "'f.svg': use -o"),
        (["view_frames", "-o", "frames"], 1, "frames has no known suffix"),
        (["remap", "a"], 2, "~mappings"),
    ],
)
def test_wrong_words(run: Run, words: list[str], code: int, text: str) -> None:
    done = run(*words)
    assert done[0] == code and text in done[1] + done[2]


def test_without_a_master(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:9/")
    for words in (["echo", "a", "b"], ["tree"], ["monitor"], ["view_frames"]):
        code, out, err = run(*words)
        assert (code, out) == (1, "") and err.startswith("ERROR: Unable to communicate with master!\n")


# Tree and pictures ----------------------------------------------------------------------------------------------------


def test_tree(eventually: Run, robot: Node) -> None:
    code, out, _ = eventually("tree", "-t", "0.5")
    assert code == 0
    lines = out.splitlines()
    assert lines[0] == "map" and len(lines) == 3
    assert lines[1].startswith("└── odom") and "/robot" in lines[1] and " Hz  " in lines[1] and "s old" in lines[1]
    assert lines[2].startswith("    └── base") and lines[2].endswith("static")
    rows = {row["frame_id"]: row for row in json.loads(eventually("tree", "-t", "0.5", "--json")[1])}
    assert rows["odom"]["parent"] == "map" and rows["odom"]["rate"] > 0 and rows["odom"]["broadcaster"] == "/robot"
    assert rows["base"]["static"] and rows["base"]["age"] is None and rows["map"]["parent"] is None


def test_view_frames(run: Run, eventually: Run, robot: Node, make_node: Make, tmp_path: Path) -> None:
    """L198"""
    code, out, _ = eventually("view_frames", "-t", "0.3", "-o", "a.svg")
    assert code == 0 and "└── odom" in out and "a.svg written" in out
    assert "base" in xml.dom.minidom.parse(str(tmp_path / "a.svg")).toxml()
    viewer = make_node("viewer", rosout=False)
    buffer = Buffer()
    with TransformListener(viewer, buffer):
        assert buffer.can_transform("map", "base", timeout=10)
        code, out, _ = run("view_frames", "--node", "viewer", "-o", "b.gv")
    assert code == 0 and "static" in out
    lines = (tmp_path / "b.gv").read_text().splitlines()
    assert lines[0] == "digraph G {" and any(line.startswith('"map" -> "odom"[label=" Broadcaster:') for line in lines)
    code, _, err = run("view_frames", "--node", "/robot", "-o", "b.gv")
    assert code == 1 and "cannot get the frames of /robot" in err
    code, _, err = run("view_frames", "-t", "0.1", "-o", "/no/such/folder/b.gv")
    assert code == 1 and "cannot write /no/such/folder/b.gv" in err


def test_view_frames_without_graphviz(
    run: Run, eventually: Run, robot: Node, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "use frames.svg" in run("view_frames", "-t", "0.3", "-o", "frames.pdf")[2]
    assert eventually("view_frames", "-t", "0.3")[0] == 0
    assert {path.name for path in tmp_path.glob("frames.*")} == {"frames.gv", "frames.svg"}


def frame(name: str, parent: str | None = None, **facts: Any) -> Frame:
    values = {"authority": "/n", "static": False, "rate": 10.0, "latest": 9.0, "oldest": 1.0, **facts}
    return Frame(name, parent, **values)


def test_drawings() -> None:
    frames = [frame('a"<', None), frame("b", 'a"<'), frame("c", 'a"<', static=True), frame("d", "b", oldest=9.0)]
    lines = format_tree(frames, 10.0).splitlines()
    assert [line.partition("/n")[0].rstrip() for line in lines] == ['a"<', "├── b", "│   └── d", "└── c"]
    assert lines[1].endswith("10.0 Hz  1.000 s old") and "once" in lines[2] and lines[3].endswith("static")
    assert '"a\\"<" -> "b"' in render_dot(frames, 10.0)
    picture = render_svg(frames, 10.0, "title & all")
    assert "a&quot;&lt;" in picture and "title &amp; all" in picture and "stroke-dasharray" in picture
    xml.dom.minidom.parseString(picture)
    assert format_tree([], 0.0) == "" and xml.dom.minidom.parseString(render_svg([], 0.0, "none"))


def test_a_loop_is_drawn_once() -> None:
    frames = [frame("a", "c"), frame("b", "a"), frame("c", "b"), frame("x", "b")]
    roots, _ = find_roots_and_children(frames)
    assert [root.name for root in roots] == ["a"]
    assert len(format_tree(frames, 10.0).splitlines()) == 4 and xml.dom.minidom.parseString(
        render_svg(frames, 10.0, "")
    )


# Publishing -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 255, "right number of arguments"),
        (["1", "2", "3", "0", "0", "0", "a"], 255, "right number of arguments"),
        (["--tf2", "1", "2", "3", "0", "0", "0", "1", "a", "b", "100"], 255, "right number of arguments"),
        (["--tf", "1", "2", "3", "0", "0", "0", "a", "b"], 255, "right number of arguments"),
        (["-h"], 0, "Examples:"),
        (["1", "2", "x", "0", "0", "0", "a", "b"], 1, "z must be a number, not 'x'"),
        (["1", "2", "3", "0", "0", "0", "a", "a"], 1, "are the same (a, a) this cannot work"),
        (["1", "2", "3", "0", "0", "0", "a", "/"], 1, "must not be empty"),
        (["1", "2", "3", "0", "0", "0", "0", "a", "b"], 1, "0 0 0 1 for no rotation"),
        (["1", "2", "3", "0", "0", "0", "a", "b", "-5"], 1, "negative"),
        (["--tf", "1", "2", "3", "0", "0", "0", "a", "b", "c"], 1, "period must be a number"),
        (["--prd"], 2, "no such option: --prd"),
        (["--tf2", "--x"], 2, "no such option: --x"),
        (["/nope"], 255, "Could not read TF from parameter server: /nope"),
    ],
)
def test_wrong_static_transforms(run: Run, words: list[str], code: int, text: str) -> None:
    """L197"""
    done = run("static_transform_publisher", *words)
    assert done[0] == code and text in done[1] + done[2]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "topic", "rotation"),
    [
        (["1", "-2", "3", "0", "0", "0", "a", "b"], "/tf_static", [0, 0, 0, 1]),
        (["1", "-2", "3", "1", "0", "0", "0", "a", "b"], "/tf_static", [1, 0, 0, 0]),
        (["1", "-2", "3", "0", "0", "0", "2", "a", "b"], "/tf_static", [0, 0, 0, 1]),
        (["1", "-2", "3", "3.141592653589793", "0", "0", "a", "b", "10"], "/tf", [0, 0, 1, 0]),
        (["1", "-2", "3", "0", "0", "-1", "0", "a", "b", "10"], "/tf", [0, 0, -1, 0]),
        (["/pose"], "/tf_static", [0, 1, 0, 0]),
    ],
)
def test_static_transforms(
    program: Callable[..., Any], make_node: Make, words: list[str], topic: str, rotation: list[float]
) -> None:
    node = make_node("listener")
    node.params["/pose"] = {
        "header": {"frame_id": "a"},
        "child_frame_id": "b",
        "transform": {"translation": {"x": 1, "y": -2.0, "z": 3}, "rotation": {"x": 0, "y": 1, "z": 0, "w": 0}},
    }
    program("-m", "pyros1", "tf", "static_transform_publisher", *words)
    message: Any = node.wait_for_message(topic, "tf2_msgs/TFMessage", timeout=20)
    (transform,) = message.transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("a", "b")
    v, q = transform.transform.translation, transform.transform.rotation
    assert (v.x, v.y, v.z) == (1, -2, 3) and [q.x, q.y, q.z, q.w] == pytest.approx(rotation)


def test_a_parameter_that_is_no_transform(run: Run, make_node: Make) -> None:
    make_node("setter").params["/pose"] = {"child_frame_id": "b"}
    code, _, err = run("static_transform_publisher", "/pose")
    assert code == 1 and "must be a transform like {header:" in err and "KeyError: 'header'" in err


def test_remap(program: Callable[..., Any], make_node: Make, run: Run) -> None:
    """L199"""
    node = make_node("old")
    child = program("-m", "pyros1", "tf", "remap", "_mappings:=[{old: base, new: robot/base}, {old: x}]")
    assert "{'base': 'robot/base'}" in child.stdout.readline()
    buffer = Buffer()
    publisher = node.advertise("/tf_old", "tf2_msgs/TFMessage")
    assert publisher.wait_for_subscribers(timeout=20)
    tf_message: Any = load_message("tf2_msgs/TFMessage")
    with TransformListener(node, buffer):
        node.timer(
            0.05,
            lambda _: publisher.publish(
                tf_message([stamped("odom", "base", node.now()), stamped("base", "arm", node.now())])
            ),
        )
        assert buffer.can_transform("odom", "arm", timeout=20)
    assert sorted(buffer.frames()) == ["arm", "odom", "robot/base"]
    code, _, err = run("remap", "_mappings:=hello")
    assert code == 1 and "must be a list" in err


# Packages -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("package", "names"),
    [
        ("tf", ["static_transform_publisher", "tf_echo", "tf_monitor", "tf_remap", "view_frames"]),
        ("tf2_ros", ["static_transform_publisher"]),
        ("tf2_tools", ["echo.py", "view_frames.py"]),
    ],
)
def test_the_packages_are_there_without_ros(package: str, names: list[str]) -> None:
    index = PackageIndex({}, installs=[])
    assert SOURCES / "pyros1/packages" in index.find(package).parents
    for name in names:
        (path,) = index.find_executable(package, name)
        assert "pyros1" in path.read_text()


def test_an_installed_ros_wins(tmp_path: Path) -> None:
    (tmp_path / "tf").mkdir()
    (tmp_path / "tf/package.xml").write_text("<package><name>tf</name></package>")
    assert PackageIndex({}, installs=[tmp_path]).find("tf") == tmp_path / "tf"
    assert PackageIndex({"ROS_PACKAGE_PATH": str(tmp_path)}, installs=[]).find("tf") == tmp_path / "tf"
    with pytest.raises(PackageNotFoundError):
        PackageIndex({}, installs=[]).find("tf_nope")


LAUNCH = """
<launch>
  <node pkg="tf" type="static_transform_publisher" name="one" args="1 0 0 0 0 0 map odom 50"/>
  <node pkg="tf2_ros" type="static_transform_publisher" name="two" args="0 2 0 0 0 0 1 odom base"/>
  <param name="pose" type="yaml" value="{header: {frame_id: base}, child_frame_id: lidar, transform:
    {translation: {x: 0.0, y: 0.0, z: 3.0}, rotation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}}"/>
  <node pkg="tf2_ros" type="static_transform_publisher" name="three" args="/pose"/>
</launch>
"""


@pytest.mark.slow
def test_launch_files_run(program: Callable[..., Any], make_node: Make, tmp_path: Path) -> None:
    """pyros1's own packages, put first so that it makes no difference whether a ROS is installed.

    Feature: launch files with `pkg="tf"` and `"tf2_ros"` run -- without ROS
    """
    file = tmp_path / "frames.launch"
    file.write_text(LAUNCH)
    program("-m", "pyros1", "launch", str(file), ROS_PACKAGE_PATH=str(SOURCES / "pyros1/packages"))
    buffer = Buffer()
    with TransformListener(make_node("listener"), buffer):
        found = buffer.lookup_transform("map", "lidar", timeout=30)
        assert buffer.chain("map", "lidar") == ["lidar", "base", "odom", "map"]
    v = found.transform.translation
    assert (v.x, v.y, v.z) == (1, 2, 3)
    assert {state.authority for state in buffer.states() if state.parent} == {"/one", "/two", "/three"}
