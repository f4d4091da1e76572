"""What completion offers, per kind of argument; shells themselves are in commands/test_setup.py."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import pyros1
from pyros1.cli import registry
from pyros1.cli.complete import join_split_words, main, quote
from pyros1.cli.main import entry
from pyros1.master import Master
from pyros1.msgs import load_message
from pyros1.msgs.std_msgs.msg import String
from pyros1.tf import StaticTransformBroadcaster


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)


def test_files_behind_links_in_a_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    package = tmp_path / "src" / "p"
    for name, file, mode in (("launch", "x.launch", 0o644), ("bin", "tool", 0o755)):
        (tmp_path / "elsewhere" / name).mkdir(parents=True)
        (tmp_path / "elsewhere" / name / file).touch(mode)
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>p</name></package>")
    for name, target in (("launch", "../../elsewhere/launch"), ("bin", "../../elsewhere/bin"), ("loop", "loop")):
        (package / name).symlink_to(target)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    assert offered(capsys, "pyros1 launch p ") == ["x.launch"]
    assert offered(capsys, "pyros1 run p ") == ["tool"]
    assert offered(capsys, "pyros1 pkg ls p/") == ["p/bin/", "p/launch/"]
    monkeypatch.chdir(package)
    assert offered(capsys, "pyros1 wtf l") == ["launch/"]


def test_packages_around_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    package = tmp_path / "work" / "my_own"
    (package / "scripts").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>my_own</name></package>")
    (package / "scripts" / "drive").touch(0o755)
    for words, meant in ((["run", "my_o"], "my_own"), (["run", "my_own", ""], "drive")):
        assert entry(["pyros1", "__complete", "bash", "", str(len(words)), "pyros1", *words]) == 0
        assert capsys.readouterr().out.split("\0")[:-1] == [meant]


@pytest.fixture
def system(master: Master, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("ROS_MASTER_URI", master.uri)
    with pyros1.Node("talker", master_uri=master.uri, argv=[], rosout=False) as node:
        node.advertise("chatter/one", String, queue_size=1)
        node.params["/gain"] = 1
        yield


def offered(capsys: pytest.CaptureFixture[str], line: str, shell: str = "bash", breaks: str = "") -> list[str]:
    words = line.split(" ")
    assert main([shell, breaks, str(len(words) - 1), *words]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return [each for each in captured.out.split("\n" if shell == "fish" else "\0") if each]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("pyros1 topi", ["topic", "topic_tools"]),
        ("pyros1 topic ec", ["echo"]),
        ("pyros1 rostopic ec", ["echo"]),
        ("/some/where/rostopic ec", ["echo"]),
        ("pyros1 topic echo --nos", ["--nostr"]),
        ("rospack depends1 minimal_n", ["minimal_nodes"]),
        ("pyros1 pkg create my_robot --example pub", ["publisher"]),
        ("pyros1 pkg create my_robot --example service --face ", ["node", "rospy"]),
        ("rosrun minimal_nodes minimal_p", ["minimal_publisher"]),
        ("roslaunch minimal_no", ["minimal_nodes"]),
        ("roslaunch minimal_nodes minimal_n", ["minimal_nodes.launch"]),
        ("roslaunch minimal_nodes minimal_nodes.launch ra", ["rate:="]),
        ("roslaunch --screen minimal_nodes minimal_nodes.launch ra", ["rate:="]),
        ("roscd minimal_nodes/l", ["minimal_nodes/launch/"]),
        ("rosed minimal_nodes minimal_nodes.l", ["minimal_nodes.launch"]),
        ("rosmsg show std_msgs/Strin", ["std_msgs/String"]),
        ("rossrv show std_srvs/Trig", ["std_srvs/Trigger"]),
        ("pyros1 msg-proto ", ["msg", "srv"]),
        ("rosmsg-proto srv std_srvs/Trig", ["std_srvs/Trigger"]),
        ("rostopic pub /x std_msgs/Strin", ["std_msgs/String"]),
        ("rostopic pub /x std_msgs/String ", ["\"data: ''\""]),
        ("rostopic pub /x no_such/Type ", []),
        ("rostopic echo /", []),
        ("rosnode info ", []),
        ("rosparam get ", []),
        ("rosrun no_such_package ", []),
        ("roslaunch no_such_package ", []),
        ("pyros1 guide ho", ["howto"]),
        ("pyros1 web pl", ["plot"]),
        ("pyros1 web --port 0 re", ["reconfigure"]),
        ("pyros1 web rqt_p", ["rqt_plot", "rqt_publisher"]),
        ("rqt_image_view /no", []),
        ("pyros1 guide check 3", ["3"]),
        ("pyros1 guide howto ac", ["access", "actions"]),
        ("nonsense ", None),
        ("pyros1 nonsense ", []),
        ("pyros1 topic nonsense ", []),
    ],
)
def test_without_a_master(capsys: pytest.CaptureFixture[str], line: str, expected: list[str] | None) -> None:
    found = offered(capsys, line)
    assert found == expected if expected is not None else found


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("rostopic echo /chat", ["/chatter/one"]),
        ("rostopic list /", ["/chatter"]),
        ("rostopic pub /chatter/one ", ["std_msgs/String"]),
        ("rosnode info ", ["/talker"]),
        ("pyros1 web nodes ", ["/talker"]),
        ("pyros1 web plot /chat", ["/chatter/one"]),
        ("pyros1 rqt_topic ", ["/chatter/one"]),
        ("rosnode ping /ta", ["/talker"]),
        ("rosparam get /g", ["/gain"]),
        ("rosservice info /talker/get", ["/talker/get_loggers"]),
        ("rosservice call /talker/get_loggers ", ['"{}"']),
    ],
)
def test_with_a_master(capsys: pytest.CaptureFixture[str], system: None, line: str, expected: list[str]) -> None:
    assert offered(capsys, line) == expected


def test_files(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("a.bag", "b.bag.active", "c.txt", ".hidden.bag", "x.launch"):
        Path(name).touch()
    Path("folder with space").mkdir()
    assert offered(capsys, "rosbag info ") == ["a.bag", "b.bag.active", '"folder with space/"']
    assert offered(capsys, "pyros1 web bag a") == offered(capsys, "pyros1 rqt_bag a") == ["a.bag"]
    assert offered(capsys, "rosbag info .h") == [".hidden.bag"]
    assert "x.launch" in offered(capsys, "roslaunch x")


def test_values_of_options_are_not_arguments(capsys: pytest.CaptureFixture[str], system: None) -> None:
    topics = offered(capsys, "pyros1 topic info ")
    assert "/chatter/one" in topics
    for line in ("topic echo -n 1 ", "topic echo --filter m -c ", "topic pub -r 10 ", "topic pub --rate=10 -1 "):
        assert offered(capsys, f"pyros1 {line}") == topics, line
    assert offered(capsys, "pyros1 topic pub -r 10 /chatter/one ") == ["std_msgs/String"]
    Path("x.bag").touch()
    assert offered(capsys, "pyros1 topic echo -n ") == []
    assert offered(capsys, "pyros1 topic echo -b ") == ["x.bag"]
    assert offered(capsys, "pyros1 bag export x.bag --storage ") == ["sqlite3", "mcap"]


def test_bash_parts_words_at_colons(capsys: pytest.CaptureFixture[str]) -> None:
    assert join_split_words(["roslaunch", "f", "a", ":=", "1", "b"]) == ["roslaunch", "f", "a:=1", "b"]
    assert join_split_words(["rostopic", "echo", ":="]) == ["rostopic", "echo:="]
    assert offered(capsys, "roslaunch minimal_nodes minimal_nodes.launch rate := ", breaks=" :=") == []


def test_fish_gets_lines_without_quotation_marks(capsys: pytest.CaptureFixture[str]) -> None:
    line = "rostopic pub /x geometry_msgs/Vector3 "
    assert offered(capsys, line, shell="fish") == ["{x: 0.0, y: 0.0, z: 0.0}"]


def test_quotation() -> None:
    assert quote("/a/b:=c") == "/a/b:=c"
    assert quote("a 'b' $c") == "\"a 'b' \\$c\""
    assert quote("it's", "'") == "'it'\\''s'"


def test_nothing_is_imported_that_verbs_do_not_need() -> None:
    import subprocess
    import sys

    code = (
        "import sys; from pyros1.cli.complete import main; main(['bash', '', '2', 'pyros1', 'topic', 'e']);"
        "heavy = {'asyncio', 'rosbags', 'numpy', 'optparse', 'socket', 'yaml'} & sys.modules.keys();"
        "sys.exit(str(heavy) if heavy else 0)"
    )
    source = str(Path(pyros1.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={"PYTHONPATH": source},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "echo\0"), done.stderr


def test_tables_name_real_commands() -> None:
    assert all(words[0] in registry.commands() for words in registry.stock_names().values())
    stock = "roscore roslaunch rosrun rostopic rosnode rosservice rosparam rosmsg rossrv rosmsg-proto rosbag rosversion"
    stock += " roswtf rosclean rosgraph rosconsole rostest rospack rosstack catkin_create_pkg rosed roscp rosls"
    assert {*stock.split()} <= {*registry.stock_names()}


def test_frames(capsys: pytest.CaptureFixture[str], master: Master, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", master.uri)
    assert offered(capsys, "pyros1 tf echo ma") == []
    with pyros1.Node("frames", master_uri=master.uri, argv=[], rosout=False) as node:
        transform = load_message("geometry_msgs/TransformStamped")()
        transform.header.frame_id, transform.child_frame_id = "map", "base_link"  # type: ignore[attr-defined]
        transform.transform.rotation.w = 1.0  # type: ignore[attr-defined]
        StaticTransformBroadcaster(node).send_transform(transform)
        assert offered(capsys, "pyros1 tf echo ma") == ["map"]
        assert offered(capsys, "pyros1 tf monitor map ") == ["base_link", "map"]
