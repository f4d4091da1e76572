"""Static transforms: whoever comes late gets those of all publishers of all bags.

Feature: static transforms of all publishers reach late subscribers -- also with `--start`
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

from pyros1.bag import BagWriter
from pyros1.bag.play.control import Control
from pyros1.bag.play.player import Player, PlayOptions
from pyros1.bag.play.read_ahead import BagSet
from pyros1.bag.play.static import StaticTransforms
from pyros1.msgs import AnyMsg
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.std_msgs.msg import Header, String
from pyros1.msgs.tf2_msgs.msg import TFMessage

from ...bodies import encode

PATIENCE = 20.0
BEGIN = 1_700_000_000 * 10**9


def header_of(cls: Any, **more: str) -> dict[str, bytes]:
    fields = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, **more}
    return {name: value.encode() for name, value in fields.items()}


def transforms(*children: str, parent: str = "map") -> bytes:
    listed = [TransformStamped(header=Header(frame_id=parent), child_frame_id=child) for child in children]
    encoded: bytes = encode(TFMessage(listed))
    return encoded


def write(path: Path, messages: list[tuple[float, str, bytes]], **more: str) -> Path:
    """A bag of /tf_static: second, publisher and bytes of each message; a text on /end at the end."""
    with BagWriter(path, chunk_threshold=100) as bag:
        conns: dict[str, int] = {}
        for second, caller, data in messages:
            if caller not in conns:
                named = {"callerid": caller, "latching": "1", **more} if caller else {}
                conns[caller] = bag.add_connection("/tf_static", header_of(TFMessage, **named))
            bag.write(conns[caller], BEGIN + int(second * 1e9), data)
        end = bag.add_connection("/end", header_of(String, callerid="/end"))
        bag.write(end, BEGIN + 10 * 10**9, encode(String("end")))
    return path


def heard_late(make_node: Any, paths: list[Path], **settings: Any) -> dict[str, str]:
    """Play bags; then child -> parent of what a subscriber gets that comes afterwards."""
    control, came, heard = Control(), threading.Event(), []

    def take(message: Any) -> None:
        heard.append(message)
        came.set()

    try:
        with BagSet([str(path) for path in paths]) as bags:
            Player(make_node("play"), bags, PlayOptions(immediate=True, **settings), control).run()
            make_node("late").subscribe("/tf_static", TFMessage, take)
            assert came.wait(PATIENCE)
    finally:
        control.close()
    return {one.child_frame_id: one.header.frame_id for one in heard[0].transforms}


def test_several_publishers_in_several_bags(make_node: Any, tmp_path: Path) -> None:
    one = write(
        tmp_path / "one.bag",
        [(0, "/a", transforms("base")), (1, "/b", transforms("laser", "imu", parent="base"))],
    )
    two = write(tmp_path / "two.bag", [(0.5, "/a", transforms("tool")), (2, "/c", transforms("imu", parent="laser"))])
    found = heard_late(make_node, [one, two])
    assert found == {"base": "map", "tool": "map", "laser": "base", "imu": "laser"}, "of a frame the last parent"


def test_after_a_seek(make_node: Any, tmp_path: Path) -> None:
    named = [(0, "/a", transforms("base")), (1, "/a", transforms("base", "tool")), (2, "/b", transforms("laser"))]
    path = write(tmp_path / "x.bag", [*named, (7, "/b", transforms("later"))])
    assert heard_late(make_node, [path], start=5.0, duration=1.0) == {"base": "map", "tool": "map", "laser": "map"}


def test_after_a_seek_in_a_bag_that_names_no_publishers(make_node: Any, tmp_path: Path) -> None:
    """Such as Python programs write: what several publishers sent at its beginning is not lost."""
    path = write(tmp_path / "x.bag", [(0, "", transforms("base")), (1, "", transforms("laser"))])
    assert heard_late(make_node, [path], start=5.0) == {"base": "map", "laser": "map"}


def test_after_a_seek_in_a_bag_that_names_one_publisher_for_several(make_node: Any, tmp_path: Path) -> None:
    """Such as stock's `rosbag filter` writes: all messages of a topic get the first one's connection."""
    path = write(tmp_path / "x.bag", [(0, "/a", transforms("base")), (1, "/a", transforms("laser"))])
    assert heard_late(make_node, [path], start=5.0) == {"base": "map", "laser": "map"}


def test_what_one_publisher_repeats_goes_out_as_stored() -> None:
    sent: list[bytes] = []
    static = StaticTransforms(lambda message: sent.append(message._buff))
    bodies = [
        transforms("a", "b"),
        transforms("a", "b", parent="odom"),
        b"\xff\xff\xff\xff spoilt",
        transforms("a", "b"),
    ]
    for body in bodies:
        static.publish(AnyMsg(body))
    assert sent == bodies
    static.publish(AnyMsg(transforms("c")))
    assert sent[-1] == transforms("a", "b", "c")
