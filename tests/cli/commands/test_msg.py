"""msg, srv, msg-proto: the shipped definitions, what is misspelt, bags, JSON (L86-L89)."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag import BagWriter
from pyros1.cli.running import run_command
from pyros1.cli.shared.definitions import library
from pyros1.msgs import load_message, load_service
from pyros1.values import load_yaml


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Callable[..., tuple[int, str, str]]:
    def call(command: str, *words: str, stdin: str = "") -> tuple[int, str, str]:
        monkeypatch.setattr("sys.stdin", io.StringIO(stdin))
        try:
            code = run_command(command, list(words))
        except SystemExit as end:
            code = int(end.code or 0)
        out, err = capsys.readouterr()
        return code, out, err

    return call


@pytest.fixture
def own_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of the test's own, own_msgs, and where it is."""
    folder = tmp_path / "own_msgs"
    for kind in ("msg", "srv"):
        (folder / kind).mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>own_msgs</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    library.cache_clear()  # a command reads its environment once
    yield folder
    library.cache_clear()


def test_constants_are_shown_as_they_are_written(run: Any, own_package: Path) -> None:
    lines = ["float64 A=-2.5e-3", "int32 B=007", "float32 C=.5", "bool D=1", 'string E=a "b" # c', "uint8 F=+5"]
    (own_package / "msg" / "Inner.msg").write_text("\n".join(lines) + " # why\nint8   x\n")
    (own_package / "msg" / "Outer.msg").write_text("Inner inner\n")
    (own_package / "srv" / "Ask.srv").write_text("float64 G=1e3\n---\nInner inner\n")
    inner = "".join(f"  {line}\n" for line in [*lines, "int8 x"])
    assert run("msg", "show", "own_msgs/Inner")[1] == "\n".join([*lines, "int8 x"]) + "\n\n"
    assert run("msg", "show", "own_msgs/Outer")[1] == f"own_msgs/Inner inner\n{inner}\n"
    assert run("srv", "show", "own_msgs/Ask")[1] == f"float64 G=1e3\n---\nown_msgs/Inner inner\n{inner}\n"


def test_no_hint_at_the_word_itself(run: Any, tmp_path: Path, own_package: Path) -> None:
    (tmp_path / "9lives" / "msg").mkdir(parents=True)
    (tmp_path / "9lives" / "package.xml").write_text("<package><name>9lives</name></package>")
    (tmp_path / "9lives" / "msg" / "M.msg").write_text("int8 x\n")
    code, out, err = run("msg", "show", "9lives/M")
    assert (code, out) == (1, "") and "[9lives/M]" in err and "did you mean" not in err
    assert "did you mean '9lives/M'?" in run("msg", "show", "9lives/msg/M")[2]


def test_a_type_that_contains_itself_is_told(run: Any, own_package: Path) -> None:
    (own_package / "msg" / "Self.msg").write_text("Self s\n")
    (own_package / "srv" / "Ask.srv").write_text("Self s\n---\n")
    for command, name in (("msg", "own_msgs/Self"), ("srv", "own_msgs/Ask")):
        code, out, err = run(command, "show", name)
        assert (code, out) == (1, "") and "the type contains itself: own_msgs/" in err


def test_a_type_that_grows_with_each_level_is_not_written_out(run: Any, own_package: Path) -> None:
    for level in range(12):
        (own_package / "msg" / f"L{level}.msg").write_text("".join(f"L{level + 1} f{i}\n" for i in range(10)))
    (own_package / "msg" / "L12.msg").write_text("int8 x\n")
    code, out, err = run("msg", "show", "own_msgs/L0")
    assert (code, out) == (1, "") and "more than 100000 lines" in err and "--raw" in err
    assert run("msg", "show", "--raw", "own_msgs/L0")[0] == 0


def test_nested_types_and_constants_l86(run: Any) -> None:
    assert run("msg", "show", "geometry_msgs/PointStamped") == (
        0,
        "std_msgs/Header header\n  uint32 seq\n  time stamp\n  string frame_id\n"
        "geometry_msgs/Point point\n  float64 x\n  float64 y\n  float64 z\n\n",
        "",
    )
    assert run("msg", "show", "GoalStatus")[1].startswith("[actionlib_msgs/GoalStatus]:\nuint8 PENDING=0\n")
    assert run("srv", "show", "std_srvs/SetBool")[1] == "bool data\n---\nbool success\nstring message\n\n"
    assert run("msg", "show", stdin="\nstd_msgs/Bool\n")[1] == "bool data\n\n"


def test_md5_is_that_of_the_classes_l88(run: Any) -> None:
    assert run("msg", "md5", "sensor_msgs/Image")[1].strip() == load_message("sensor_msgs/Image")._md5sum
    assert run("srv", "md5", "std_srvs/Empty")[1].strip() == load_service("std_srvs/Empty")._md5sum


@pytest.mark.parametrize(
    ("words", "code", "hint"),
    [
        (("show", "std_msgs/Strnig"), 1, "Unable to load msg [std_msgs/Strnig]"),
        (("show", "Twits"), 1, "Could not find msg 'Twits' (did you mean 'Twist'?)"),
        (("md5", "std_msgs/Strnig"), 0, "Cannot locate [std_msgs/Strnig] (did you mean 'std_msgs/String'?)"),
        (("md5", "Nope"), 0, "No messages matching the name [Nope]"),
        (("package", "std_mgs"), 64, "Invalid package: std_mgs (did you mean 'std_msgs'?)"),
        (("show", "a::b"), 2, "does not understand C++-style"),
        (("show", "a.b"), 2, "invalid message type 'a.b'"),
        (("show",), 64, "no name was given"),
        (("show", "-b", "nope.bag", "std_msgs/Bool"), 1, "bag file [nope.bag] does not exist"),
    ],
)
def test_what_is_wrong_is_said_l87_l89(run: Any, words: tuple[str, ...], code: int, hint: str) -> None:
    got, out, err = run("msg", *words)
    assert (got, out) == (code, "") and hint in err


def test_only_a_wrong_word_is_an_error_l87(run: Any) -> None:
    assert run("msg")[0] == run("srv")[0] == 0
    assert run("msg", "bogus")[0] == run("srv", "bogus")[0] == 64


def test_json(run: Any) -> None:
    assert "std_msgs/String" in json.loads(run("msg", "list", "--json")[1])
    assert "std_srvs" in json.loads(run("srv", "packages", "--json")[1])
    assert json.loads(run("srv", "package", "--json", "std_srvs")[1]) == [
        "std_srvs/Empty", "std_srvs/SetBool", "std_srvs/Trigger",
    ]  # fmt: skip


def test_definitions_in_bags_l86(run: Any, tmp_path: Path) -> None:
    image = load_message("sensor_msgs/Image")
    fields = {"type": image._type, "md5sum": image._md5sum, "message_definition": image._full_text}
    with BagWriter(tmp_path / "a.bag") as bag:
        bag.add_connection("/t", {name: value.encode() for name, value in fields.items()})
    code, out, _ = run("msg", "show", "-b", str(tmp_path / "a.bag"), "sensor_msgs/Image")
    assert (code, out) == run("msg", "show", "sensor_msgs/Image")[:2]
    assert run("msg", "show", "-b", str(tmp_path / "a.bag"), "std_msgs/Header")[1].startswith("uint32 seq\n")
    assert run("msg", "show", "-b", str(tmp_path / "a.bag"), "std_msgs/Bool")[:2] == (0, "")
    (tmp_path / "bad.bag").write_bytes(b"nonsense")
    assert run("msg", "show", "-b", str(tmp_path / "bad.bag"), "std_msgs/Bool")[0] == 1


@pytest.mark.parametrize("name", ["std_msgs/String", "nav_msgs/Odometry", "visualization_msgs/MarkerArray"])
@pytest.mark.parametrize("style", [(), ("-f", "0"), ("-f", "1")])
def test_a_template_is_a_message_l89(run: Any, name: str, style: tuple[str, ...]) -> None:
    code, out, _ = run("msg-proto", "msg", "-H", "-e", *style, name)
    assert code == 0 and list(load_yaml(out)) == list(load_message(name).__slots__)


def test_templates_l89(run: Any) -> None:
    assert run("msg-proto", "msg", "std_msgs/String") == (0, "\"data: ''\"\n", "")
    assert run("msg-proto", "srv", "-H", "std_srvs/Empty")[1] == "{}\n"
    assert run("msg-proto", "msg", "-H", "-x", "header,name,effort", "sensor_msgs/JointState")[1] == (
        "position:\n- 0\nvelocity:\n- 0\n"
    )
    assert (
        run("msg-proto", "msg", "-H", "-x", "stamp,frame_id,pose", "geometry_msgs/PoseStamped")[1]
        == "header:\n  seq: 0\n"
    )
    assert run("msg-proto", "msg", "-s", "nope/X") == (0, "", "")
    assert run("msg-proto", "nonsense", "x")[0] == 64
