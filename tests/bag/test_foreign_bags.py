"""Bags of publishers that are not stock's: definitions that are cut, empty or garbled, and bytes behind messages."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.bag import BagWriter
from pyros1.bag.errors import BagError
from pyros1.cli.running import run_command
from pyros1.msgs import from_definition
from pyros1.msgs.geometry_msgs.msg import Twist

from ..bodies import encode
from .made import header_of

bag_command, msg, topic = (partial(run_command, name) for name in ("bag", "msg", "topic"))
SEPARATOR = "\n" + "=" * 80 + "\n"
OWN: Any = from_definition("own_msgs/Robot", f"string name\nPart part{SEPARATOR}MSG: own_msgs/Part\nfloat64 size")
TEXTS = {
    "whole": Twist._full_text,
    "empty": "",
    "without nested types": Twist._full_text.split(SEPARATOR)[0],
    "cut": Twist._full_text[:-30],
    "short separators": Twist._full_text.replace("=" * 80, "=" * 30),
    "garbled": "Vec%tor3 linear\n=",
}


def foreign_bag(path: Path, text: str, behind: bytes = b"") -> Path:
    """A bag with a Twist on /cmd_vel at 1 s, and an own_msgs/Robot on /robot at 2 s; another publisher has its text."""
    twist, robot = Twist(), OWN(name="r2")
    twist.linear.x, robot.part.size = 1.5, 2.5
    with BagWriter(path) as writer:
        header = {**header_of(Twist), "message_definition": text.encode()}
        writer.write(writer.add_connection("/cmd_vel", header), 10**9, encode(twist) + behind)
        for who, definition in (("/foreign", "Part part"), ("/stock", OWN._full_text)):
            fields = {**header_of(OWN, callerid=who), "message_definition": definition.encode()}
            connection = writer.add_connection("/robot", fields)
            if who == "/foreign":
                writer.write(connection, 2 * 10**9, encode(robot) + behind)
    return path


@pytest.fixture(params=TEXTS)
def path(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    return foreign_bag(tmp_path / "x.bag", TEXTS[request.param], b"\xc3")


def values(path: Path) -> list[tuple[Any, ...]]:
    with pyros1.bag.open(path) as bag:
        twist, robot = (found.message for found in bag.messages())
        return [(twist.linear.x, twist.angular.z), (robot.name, robot.part.size)]


EXPECTED = [(1.5, 0.0), ("r2", 2.5)]


def test_they_are_read(path: Path) -> None:
    assert values(path) == EXPECTED
    with pyros1.bag.open(path) as bag:
        assert bag.columns("/cmd_vel", ["linear.x"])["linear.x"] == [1.5]
        assert list(bag.arrays("/robot", ["part.size"])["part.size"]) == [2.5]


def test_tools_show_them(path: Path, call_main: Any) -> None:
    code, out, err = call_main(topic, "echo", "-b", path, "/cmd_vel/linear")
    assert (code, out, err) == (0, "x: 1.5\ny: 0.0\nz: 0.0\n---\n", "")
    code, out, err = call_main(topic, "echo", "-b", path, "/robot")
    assert (code, out, err) == (0, 'name: "r2"\npart: \n  size: 2.5\n---\n', "")
    for name, words in (
        ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\n  float64 x"),
        ("own_msgs/Robot", "size"),
    ):
        code, out, err = call_main(msg, "show", "-b", path, name)
        assert (code, err) == (0, "") and words in out
    assert call_main(bag_command, "info", path)[0] == 0


@pytest.mark.parametrize("words", [["--format", "ros2"], ["--format", "mcap"], ["--format", "mcap", "--ros1"]], ids=str)
def test_they_are_exported_and_imported(path: Path, tmp_path: Path, call_main: Any, words: list[str]) -> None:
    if "--ros1" not in words:
        pytest.importorskip("rosbags")
    out = tmp_path / ("out.mcap" if "mcap" in words else "out")
    assert call_main(bag_command, "export", "-q", *words, "-o", out, path)[0] == 0
    assert call_main(bag_command, "import", "-q", "-o", tmp_path / "back.bag", out)[0] == 0
    assert values(tmp_path / "back.bag") == EXPECTED


def test_they_are_written_as_text_and_filtered(path: Path, tmp_path: Path, call_main: Any) -> None:
    assert call_main(bag_command, "export", "-q", "-o", tmp_path / "x.jsonl", path)[0] == 0
    lines = [json.loads(line)["message"] for line in (tmp_path / "x.jsonl").read_text().splitlines()]
    assert [lines[0]["linear"]["x"], lines[1]["part"]["size"]] == [1.5, 2.5]
    wanted = "topic == '/robot' and m.part.size == 2.5 or topic == '/cmd_vel' and m.linear.x == 1.5"
    assert "2 of 2 messages" in "".join(call_main(bag_command, "filter", path, tmp_path / "y.bag", wanted)[1:])


def test_what_no_definition_fits_is_an_error(tmp_path: Path) -> None:
    path = foreign_bag(tmp_path / "x.bag", "%")
    data = path.read_bytes().replace(Twist._md5sum.encode(), b"1" * 32)
    path.write_bytes(data)
    with pyros1.bag.open(path) as bag, pytest.raises(BagError, match=r"message on /cmd_vel at 1\.0+: "):
        next(iter(bag.messages()))
