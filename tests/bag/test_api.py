"""Arrays for numpy and pandas, and how far long reading is.

Feature: bags in Python -- `pyros1.bag.open(...)`: by topic and time, arrays for numpy and pandas
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pyros1.bag
from pyros1.bag import BagError, BagWriter
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import Message, from_definition
from pyros1.msgs.geometry_msgs.msg import Point, Pose, PoseArray

from ..bodies import encode
from .conftest import Make
from .made import header_of

SAMPLE = """float32 speed
bool on
uint8[] data
float64[3] position
int16[] ranges
string[] names
string name
time stamp
time time
duration[] waits
Point point
================================================================================
MSG: test_msgs/Point
int64 x
"""


@pytest.fixture
def samples(tmp_path: Path) -> Path:
    cls: type[Message] = from_definition("test_msgs/Sample", SAMPLE)
    with BagWriter(tmp_path / "samples.bag") as writer:
        conn = writer.add_connection("/s", header_of(cls))
        for i in range(3):
            message = cls(
                speed=i / 2,
                on=i == 1,
                data=bytes([i, 255]),
                position=[i, i, 0.5],
                ranges=list(range(i)),
                names=["a", "b"],
                name=str(i),
                stamp=Time(i, 500_000_000),
                time=Time(9, 0),
                waits=[Duration(i, 0)],
            )
            message.point.x = 1 << 60
            writer.write(conn, i * 1_000_000_000, encode(message))
    return tmp_path / "samples.bag"


def test_arrays_have_the_types_of_their_fields(samples: Path) -> None:
    with pyros1.bag.open(samples) as bag:
        columns = bag.arrays("/s")
    assert list(columns) == ["time", "speed", "on", "name", "stamp", "time_", "point.x"]
    found = {name: (str(values.dtype), values.tolist()) for name, values in columns.items()}
    assert found == {
        "time": ("float64", [0.0, 1.0, 2.0]),
        "speed": ("float32", [0.0, 0.5, 1.0]),
        "on": ("bool", [False, True, False]),
        "name": ("object", ["0", "1", "2"]),
        "stamp": ("float64", [0.5, 1.5, 2.5]),
        "time_": ("float64", [9.0] * 3),
        "point.x": ("int64", [1 << 60] * 3),
    }


def test_arrays_of_one_length_make_a_table(samples: Path) -> None:
    with pyros1.bag.open(samples) as bag:
        columns = bag.arrays("/s", ["data", "position", "ranges", "names", "stamp.secs", "waits"])
        assert (columns["data"].dtype, columns["data"].tolist()) == (np.uint8, [[0, 255], [1, 255], [2, 255]])
        assert columns["position"].shape == (3, 3)
        assert [values.tolist() for values in columns["ranges"]] == [[], [0], [0, 1]]
        assert columns["names"][0] == ["a", "b"]
        assert columns["stamp.secs"].tolist() == [0, 1, 2]
        assert columns["waits"][2] == [Duration(2, 0)]
        with pytest.raises(AttributeError):
            bag.arrays("/s", ["nope"])


def test_messages_with_arrays_as_numpy_arrays(tmp_path: Path) -> None:
    with pyros1.bag.open(tmp_path / "poses.bag", "w") as bag:
        for x in (1.0, 2.0):
            bag.write("/poses", PoseArray(poses=[Pose(position=Point(x=x)), Pose()]), x)
    with pyros1.bag.open(tmp_path / "poses.bag") as bag:
        assert [each.message.poses.position.x.tolist() for each in bag.messages(arrays="numpy")] == [[1, 0], [2, 0]]
        assert [type(each.message.poses) for each in bag.messages()] == [list, list]
        with pytest.raises(ValueError, match="arrays must be"):
            next(bag.messages(arrays="list"))


def test_arrays_of_some_time_or_none(make_bag: Make) -> None:
    with pyros1.bag.open(make_bag(count=6)) as bag:
        columns = bag.arrays("/a")
        assert {name: values.tolist() for name, values in columns.items()} == {
            "time": [100.0, 100.02, 100.04],
            "data": [0, 2, 4],
        }
        assert bag.arrays("/b", ["data"], end=0.01)["data"].tolist() == ["1"]
        empty = bag.arrays("/a", start=5.0)
        assert {name: (str(values.dtype), len(values)) for name, values in empty.items()} == {
            "time": ("float64", 0),
            "data": (str(columns["data"].dtype), 0),
        }
        assert "message_definition" not in repr(bag.connections)


def test_a_topic_that_is_not_there_is_named(make_bag: Make, tmp_path: Path) -> None:
    """Iterating yields nothing, as stock's read_messages does; a table without rows would be taken for the answer."""
    with BagWriter(tmp_path / "odd.bag") as writer:
        writer.add_connection("/odometry", header_of(from_definition("test_msgs/Sample", SAMPLE)))
        writer.add_connection("/undefined", {"type": b"no/Where", "md5sum": b"*", "message_definition": b"Gone x"})
    hint = r"\(did you mean '/odometry'\?\)$"
    with pyros1.bag.open(tmp_path / "odd.bag") as bag:
        for ask in (bag.arrays, bag.columns):
            for name in ("/odometri", "odometri"):
                with pytest.raises(BagError, match=rf"odd\.bag: there is no topic {name} {hint}"):
                    ask(name, ["speed"])
            with pytest.raises(BagError, match=r"odd\.bag: the type of /undefined: "):
                ask("/undefined")
        assert list(bag.arrays("odometry", ["speed"])) == ["time", "speed"], "its topic is there, without messages"
        assert list(bag.messages("/odometri")) == []
    BagWriter(tmp_path / "empty.bag").close()
    with pyros1.bag.open(tmp_path / "empty.bag") as bag, pytest.raises(BagError, match="/x; the bag has no topics"):
        bag.arrays("/x")


def test_progress_counts_the_bags_time(make_bag: Make) -> None:
    with pyros1.bag.open(make_bag(count=11)) as bag:
        done: list[tuple[int, int]] = []
        list(bag.messages(start=0.05, progress=lambda *call: done.append(call)))
    assert done[0] == (0, 50_000_000)
    assert done[-1] == (50_000_000, 50_000_000)
    assert len(done) == 6
