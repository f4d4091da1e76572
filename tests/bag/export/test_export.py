"""bag export and bag import, as commands.

Feature: bags for other programs -- `pyros1 bag export`: CSV as in stock ROS, JSON, images, video, MCAP, ROS 2 bags
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Nodetype

import pyros1.bag
from pyros1.bag import BagWriter
from pyros1.bag.export.extras import import_extra
from pyros1.cli.running import run_command
from pyros1.ground.errors import Error
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import Message, from_definition, load_message
from pyros1.msgs.base import nested_classes
from pyros1.observe import image_files
from pyros1.ros2_types.legal_names import LegalNames

from ...bodies import encode
from ..conftest import Make, values
from ..made import header_of

Run = Callable[..., tuple[int, str, str]]

bag = partial(run_command, "bag")
topic = partial(run_command, "topic")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: Any, tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)

    def call(*words: object, main: Callable[[list[str]], int] = bag) -> tuple[int, str, str]:
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = int(end.code or 0)
        out, err = capsys.readouterr()
        return code, out, err

    return call


def write_bag(path: Path, *messages: tuple[str, Message], **header: str) -> Path:
    """A bag with a message per second."""
    with BagWriter(path) as writer:
        numbers: dict[str, int] = {}
        for second, (name, message) in enumerate(messages):
            cls = type(message)
            if name not in numbers:
                numbers[name] = writer.add_connection(name, header_of(cls, **header))
            writer.write(numbers[name], second * 1_000_000_000, encode(message))
    return path


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


# Text -------------------------------------------------------------------------------------------------------------


def test_csv_is_what_topic_echo_prints(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag(count=6)
    assert run("export", "x.bag", "--format", "csv") == (0, "x_csv: 6 messages of 2 topics\n", "")
    assert files(tmp_path) == ["x.bag", "x_csv/a.csv", "x_csv/b.csv"]
    for name in ("a", "b"):
        _, echoed, _ = run("echo", "-b", "x.bag", "-p", f"/{name}", main=topic)
        assert (tmp_path / "x_csv" / f"{name}.csv").read_text() == echoed
    assert run("export", "x.bag", "-o", "-", "--format", "csv", "--topics", "/b", "--from", "0.04")[1] == (
        "%time,field.data\n100050000000,5\n"
    )
    assert run("export", "x.bag", "-o", "b.csv", "--topics", "b", "--nostr", "-q") == (0, "", "")
    assert (tmp_path / "b.csv").read_text() == "%time,\n100010000000,\n100030000000,\n100050000000,\n"


def test_csv_writes_fields_as_stock_does(run: Run, tmp_path: Path) -> None:
    """What stock `rostopic echo -b -p` prints of the same message."""
    definition = "bool b\nbool[] bs\nuint8[] data\nchar[2] c\nint8[] n\nstring s\nduration d\nfloat32 f\nk/Sub[] subs\n"
    cls = from_definition("k/Kinds", f"{definition}{'=' * 80}\nMSG: k/Sub\ntime t\nuint8[] y\nbool x\n")
    sub = nested_classes(cls)["k/Sub"]
    message = cls(
        b=True, bs=[True, False], data=b"xyz", c=b"ab", n=[-1], s='a,"b', d=Duration(-1, 5), f=0.1, subs=[sub()]
    )
    write_bag(tmp_path / "x.bag", ("/k", message), ("/none", from_definition("k/None", "uint8[] data")()))
    assert run("export", "x.bag", "--format", "csv")[0] == 0
    assert (tmp_path / "x_csv" / "k.csv").read_text() == (
        "%time,field.b,field.bs0,field.bs1,field.n0,field.s,field.d,field.f,field.subs0.t,field.subs0.x\n"
        '0,1,1,0,-1,a,"b,-999999995,0.10000000149011612,0,0\n'
    )
    assert (tmp_path / "x_csv" / "none.csv").read_text() == "%time,\n1000000000,\n"
    for name in ("k", "none"):
        _, echoed, _ = run("echo", "-b", "x.bag", "-p", f"/{name}", main=topic)
        assert (tmp_path / "x_csv" / f"{name}.csv").read_text() == echoed
    assert run("export", "x.bag", "-o", "-", "--format", "csv", "--topics", "/k", "--noarr", "--nostr")[1] == (
        "%time,field.b,field.d,field.f\n0,1,-999999995,0.10000000149011612\n"
    )


def test_json_lines_name_topic_and_time(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag(count=2)
    assert run("export", "x.bag", "-o", "x.jsonl")[0] == 0
    lines = [json.loads(line) for line in (tmp_path / "x.jsonl").read_text().splitlines()]
    assert lines == [
        {"topic": "/a", "type": "std_msgs/Int32", "time": {"secs": 100, "nsecs": 0}, "message": {"data": 0}},
        {"topic": "/b", "type": "std_msgs/String", "time": {"secs": 100, "nsecs": 10**7}, "message": {"data": "1"}},
    ]
    assert run("export", "x.bag", "-o", "-", "--format", "jsonl", "--bare")[1] == '{"data": 0}\n{"data": "1"}\n'


def test_several_bags_become_one_table_by_time(run: Run, make_bag: Make) -> None:
    make_bag(count=6)
    run("filter", "x.bag", "early.bag", "m.data == 0 or m.data == 4", "--topics", "/a")
    run("filter", "x.bag", "late.bag", "m.data == 2", "--topics", "/a")
    _, out, _ = run("export", "late.bag", "early.bag", "-o", "-", "--format", "csv")
    assert [line.rpartition(",")[2] for line in out.splitlines()[1:]] == ["0", "2", "4"]


def test_names_of_files_are_safe_and_different(run: Run, tmp_path: Path) -> None:
    word = load_message("std_msgs/String")(data="x")
    write_bag(tmp_path / "x.bag", ("/a/b", word), ("/../../etc", word), ("a b", word), ("a_b", word))
    assert run("export", "x.bag", "-o", "out", "--format", "csv")[0] == 0
    assert files(tmp_path / "out") == ["-..-etc.csv", "a-b.csv", "a_b.csv", "a_b_2.csv"]


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 2, "at least one bag file"),
        (["x.bag"], 2, "must specify --format"),
        (["x.bag", "-o", "out.mcap", "--format", "csv"], 2, "does not match the output name"),
        (["x.bag", "-o", "-", "--format", "mcap"], 2, "needs a file or folder"),
        (["x.bag", "--format", "xml"], 2, "invalid choice"),
        (["nope.bag", "--format", "csv"], 1, "nope.bag: No such file"),
        (["x.bag", "-o", "x.csv"], 1, "2 are selected"),
        (["x.bag", "-o", "here.jsonl"], 1, "here.jsonl already exists: use -f to replace it"),
        (["x.bag", "-o", "full", "--format", "csv"], 1, "full already exists"),
        (["x.bag", "-o", "no/x.jsonl"], 1, "the folder no does not exist"),
        (["x.bag", "-f", "--format", "jsonl", "-o", "x.bag"], 1, "Cannot use same file"),
        (["x.bag", "-f", "--format", "jsonl", "-o", "full"], 1, "full is a folder"),
        (["x.bag", "-f", "--format", "csv", "-o", "bad.bag"], 1, "bad.bag is a file"),
        (["x.bag", "-o", "x.jsonl", "--topics", "/c"], 1, "no topic /c in x.bag"),
        (["x.bag", "-o", "x.jsonl", "--topics", "/a,/c"], 1, "no topic /c in x.bag"),
        (["x.bag", "-o", "x.jsonl", "--from", "@200"], 1, "no messages for the selected topics and times"),
        (["x.bag", "-o", "x.mcap", "--distro", "jazy"], 2, "unknown distribution 'jazy'"),
        (["x.bag", "--format", "images"], 1, "no images in x.bag"),
        (["cut.bag", "-o", "x.jsonl"], 1, "bag reindex"),
        (["bad.bag", "-o", "x.jsonl"], 1, "bad.bag: message on /x at"),
        (["bad.bag", "-o", "x.mcap"], 1, "x.mcap: message on /x at 1.000000 (std_msgs/String) cannot be converted"),
        (["bad.bag", "-o", "out", "--format", "ros2"], 1, "cannot be converted"),
    ],
)
def test_what_cannot_be_exported_leaves_nothing(
    run: Run, make_bag: Make, tmp_path: Path, words: list[str], code: int, text: str
) -> None:
    make_bag(count=4)
    (tmp_path / "here.jsonl").write_text("mine")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").touch()
    (tmp_path / "cut.bag").write_bytes((tmp_path / "x.bag").read_bytes()[:-50])
    with BagWriter(tmp_path / "bad.bag") as writer:
        conn = writer.add_connection("/x", header_of(load_message("std_msgs/String")))
        writer.write(conn, 0, b"\1\0\0\0a")
        writer.write(conn, 10**9, b"\xff\0\0")
    before = files(tmp_path)
    result = run("export", *words)
    assert (result[0], text in result[2]) == (code, True), result
    assert files(tmp_path) == before
    assert (tmp_path / "here.jsonl").read_text() == "mine"
    assert not list(tmp_path.glob("*.tmp"))


def test_force_replaces_files_and_spares_others(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag(count=4)
    (tmp_path / "out").mkdir()
    for name in ("mine", "a.csv"):
        (tmp_path / "out" / name).write_text("old")
    assert run("export", "-f", "x.bag", "-o", "out", "--format", "csv")[0] == 0
    assert files(tmp_path / "out") == ["a.csv", "b.csv", "mine"]
    assert (tmp_path / "out" / "a.csv").read_text().startswith("%time")


# Images -----------------------------------------------------------------------------------------------------------


class FakePillow(ModuleType):
    """Writes arrays as text."""

    def fromarray(self, array: Any) -> Any:
        return FakeImage(array)


class FakeImage:
    def __init__(self, array: Any) -> None:
        self.array = array

    def save(self, file: Any, kind: str) -> None:
        file.write(f"{kind} {self.array.dtype} {self.array.tolist()}".encode())


@pytest.fixture
def pillow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bag.export.image_files.import_extra", lambda *words: FakePillow("PIL.Image"))


def an_image(encoding: str, data: bytes, width: int, stamp: Time | None = None, step: int = 0) -> Message:
    step = step or len(data)
    image: Any = load_message("sensor_msgs/Image")(
        encoding=encoding, data=data, width=width, height=len(data) // step, step=step
    )
    image.header.stamp = stamp or Time()
    return image  # type: ignore[no-any-return]


@pytest.mark.usefixtures("pillow")
def test_images_become_files_named_by_their_stamps(run: Run, tmp_path: Path) -> None:
    compressed: Any = load_message("sensor_msgs/CompressedImage")(format="jpeg", data=b"\xff\xd8jpeg")
    depth: Any = load_message("sensor_msgs/CompressedImage")(
        format="16UC1; compressedDepth png", data=bytes(12) + b"\x89PNG depth"
    )
    write_bag(
        tmp_path / "x.bag",
        ("/cam/raw", an_image("bgr8", b"\1\2\3", 1, Time(5, 6))),
        ("/cam/raw", an_image("mono16", b"\1\2", 1, Time(5, 6))),
        ("/cam/raw", an_image("32FC1", b"\0\0\x80\x3f", 1)),
        ("/cam/jpg", compressed),
        ("/depth", depth),
        ("/word", load_message("std_msgs/String")()),
    )
    assert run("export", "x.bag", "--format", "images") == (0, "x_images: 5 messages of 3 topics\n", "")
    found = {name: (tmp_path / "x_images" / name).read_bytes() for name in files(tmp_path / "x_images")}
    assert found == {
        "cam-raw/5.000000006.png": b"PNG uint8 [[[3, 2, 1]]]",
        "cam-raw/5.000000006_2.png": b"PNG uint16 [[513]]",
        "cam-raw/2.000000000.tiff": b"TIFF float32 [[1.0]]",
        "cam-jpg/3.000000000.jpg": b"\xff\xd8jpeg",
        "depth/4.000000000.png": b"\x89PNG depth",
    }


@pytest.mark.usefixtures("pillow")
def test_images_that_cannot_be_written_are_named(run: Run, tmp_path: Path) -> None:
    write_bag(
        tmp_path / "x.bag",
        ("/a", an_image("mono8", b"\1", 1)),
        ("/a", an_image("jpeg2000", b"\1", 1)),
        ("/b", an_image("rgb8", b"\1\2", 1)),
        ("/b", an_image("16SC3", b"\1\2\3\4\5\6", 1)),
        ("/b", an_image("16SC3", b"\1\2\3\4\5\6", 1)),
    )
    code, out, err = run("export", "x.bag", "--format", "images")
    assert (code, out) == (1, "x_images: 1 messages of 2 topics\n")
    assert err.splitlines() == [
        "WARNING: /a: 1 message left out: images with the encoding 'jpeg2000' are not supported",
        "WARNING: /b: 1 message left out: the image's step is 2, but rows of 1 pixels in rgb8 take 3 bytes",
        "WARNING: /b: 2 messages left out: PNG and TIFF files cannot store images of the encoding '16SC3'; "
        "try --format video",
    ]


def test_sixteen_bits_and_depths_in_metres_are_exported_whole(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("PIL", reason="the extra `images` brings it")
    colours = np.arange(24, dtype="<u2").reshape(2, 4, 3) * 2001
    file = image_files.encode(np.array([[300, 0]], np.uint16), "png")
    depth: Any = load_message("sensor_msgs/CompressedImage")(
        format="32FC1; compressedDepth png", data=struct.pack("<iff", 0, 100.0, 50.0) + file
    )
    write_bag(
        tmp_path / "x.bag",
        ("/rgb", an_image("rgb16", colours.tobytes(), 4, step=24)),
        ("/bgr", an_image("bgr16", colours.tobytes(), 4, step=24)),
        ("/depth", depth),
    )
    assert run("export", "x.bag", "--format", "images")[0] == 0
    found = {
        name.partition("/")[0]: image_files.decode((tmp_path / "x_images" / name).read_bytes())
        for name in files(tmp_path / "x_images")
    }
    assert np.array_equal(found["rgb"], colours) and np.array_equal(found["bgr"], colours[:, :, ::-1])
    assert (
        found["depth"].dtype == np.float32
        and found["depth"][0, 0] == np.float32(0.4)
        and np.isnan(found["depth"][0, 1])
    )


@pytest.mark.parametrize(("kind", "package"), [("images", "images"), ("video", "video")])
def test_an_extra_that_is_missing_is_named(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, package: str
) -> None:
    for module in ("PIL", "PIL.Image", "av"):
        monkeypatch.setitem(__import__("sys").modules, module, None)
    write_bag(tmp_path / "x.bag", ("/a", an_image("mono8", b"\1", 1)))
    code, _, err = run("export", "x.bag", "--format", kind)
    assert code == 1
    assert len(err.splitlines()) == 1
    assert f"pip install 'pyros1[{package}]'" in err
    assert files(tmp_path) == ["x.bag"]
    with pytest.raises(Error, match="nope_not_there"):
        import_extra("nope_not_there.x", "x")


# MCAP and ROS 2 ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("output", "more"),
    [("out.mcap", []), ("out", ["--format", "ros2"]), ("out", ["--format", "ros2", "--storage", "mcap"])],
)
def test_what_goes_to_ros_2_comes_back(run: Run, tmp_path: Path, output: str, more: list[str]) -> None:
    """Feature: importing ROS 2 bags -- `pyros1 bag import`, with ROS 1's MD5 sums"""
    own: Any = from_definition(
        "my_msgs/Own",
        "int8 X=3\nstd_msgs/String[] words\nduration d\nuint8 b\n" + "=" * 80 + "\nMSG: std_msgs/String\nstring data\n",
    )()
    own.words, own.d, own.b = [load_message("std_msgs/String")(data="ä")], Duration(-1, 5), 7
    info: Any = load_message("sensor_msgs/CameraInfo")(D=[0.5, 1.5], K=[float(i) for i in range(9)])
    info.header.frame_id, info.header.stamp = "cam", Time(3, 4)
    mark: Any = load_message("visualization_msgs/Marker")(text="hello", mesh_resource="m", id=7)
    write_bag(tmp_path / "x.bag", ("/own", own), ("/info", info), ("/mark", mark), ("/own", own), latching="1")
    assert run("export", "x.bag", "-o", output, *more) == (0, f"{output}: 4 messages of 3 topics\n", "")
    assert run("import", output, "-o", "y.bag") == (0, "y.bag: 4 messages of 3 topics\n", "")
    with pyros1.bag.open("y.bag") as bag:
        found = list(bag.messages())
        assert [(item.topic, item.time.secs) for item in found] == [
            ("/own", 0),
            ("/info", 1),
            ("/mark", 2),
            ("/own", 3),
        ]
        assert [str(item.message) for item in found] == [str(message) for message in (own, info, mark, own)]
        assert all(connection.latching for connection in bag.connections)
        sums = {connection.type: connection.md5sum for connection in bag.connections}
        definition = {connection.type: connection.definition for connection in bag.connections}
    assert sums == {type(message)._type: type(message)._md5sum for message in (own, info, mark)}
    assert definition["sensor_msgs/CameraInfo"] == type(info)._full_text


def test_constants_that_rosbags_cannot_read_do_no_harm(run: Run, tmp_path: Path) -> None:
    write_bag(tmp_path / "x.bag", ("/own", from_definition("my_msgs/Own", "string EMPTY=\r\nint8 x\r\n")(x=5)))
    assert run("export", "x.bag", "-o", "x.mcap") == (0, "x.mcap: 1 messages of 1 topic\n", "")
    assert run("import", "x.mcap", "-o", "y.bag")[0] == 0
    with pyros1.bag.open("y.bag") as bag:
        assert [item.message.x for item in bag.messages()] == [5]


def test_import_takes_topics_and_compression(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag(count=6)
    run("export", "x.bag", "-o", "x.mcap")
    assert (
        run("import", "x.mcap", "--topics", "/b", "--lz4")[2] == "ERROR: x.bag already exists: use -f to replace it\n"
    )
    assert run("import", "x.mcap", "--topics", "/b", "--lz4", "-f", "-q") == (0, "", "")
    assert values(tmp_path / "x.bag") == [1, 3, 5]


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 2, "one ROS 2 bag"),
        (["nope.mcap"], 1, "nope.mcap: No such file"),
        (["folder"], 1, "no metadata.yaml"),
        (["x.bag", "-o", "y.bag"], 1, "neither the folder of a ROS 2 bag"),
        (["cut.mcap"], 1, "cut off or damaged"),
        (["empty.db3"], 1, "rosbags cannot read it"),
        (["x.mcap", "-o", "y.bag", "--topics", "/c"], 1, "no topic /c in x.mcap"),
    ],
)
def test_what_cannot_be_imported_leaves_nothing(
    run: Run, make_bag: Make, tmp_path: Path, words: list[str], code: int, text: str
) -> None:
    make_bag(count=4)
    run("export", "x.bag", "-o", "x.mcap")
    (tmp_path / "cut.mcap").write_bytes((tmp_path / "x.mcap").read_bytes()[:600])
    (tmp_path / "empty.db3").touch()
    (tmp_path / "folder").mkdir()
    before = files(tmp_path)
    result = run("import", *words)
    assert (result[0], text in result[2]) == (code, True), result
    assert files(tmp_path) == before


def test_usage(run: Run) -> None:
    out = run("export", "-h")[1]
    assert "--format" in out
    assert "ROS 2" in run("import", "-h")[1]
    assert "export" in run()[1]


STRANGE = """Header header
time timeStamp
float32 X
float32 x
MarkerSet[] markerSets
geometry_msgs/Point[2] Corners_
string from
================================================================================
MSG: Mocap/MarkerSet
string setName
uint8 num__markers
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
"""

FIELD = r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*"
"""As rosidl has it."""


@pytest.mark.parametrize("output", ["out.mcap", "out"])
def test_names_that_ros_2_does_not_allow_are_made_ones_that_it_does(run: Run, tmp_path: Path, output: str) -> None:
    """Feature: names that ROS 2 does not allow are converted -- by a fixed rule, with a message: package
    `Mocap` becomes `mocap`, field `timeStamp` `time_stamp`, type `my_type` `MyType`; `bag export
    --ros1` keeps them
    """
    cls: Any = from_definition("Mocap/rigid_body", STRANGE)
    body = cls(timeStamp=Time(5, 6), X=1.5, x=2.5)
    body.markerSets = [nested_classes(cls)["Mocap/MarkerSet"](setName="s", num__markers=3)]
    body.Corners_[1].y = 4.0
    body.from_ = "me"
    write_bag(tmp_path / "x.bag", ("/body", body), ("/text", load_message("std_msgs/String")(data="hello")))
    code, _, err = run("export", "x.bag", "-o", output, "--format", "mcap" if output.endswith("mcap") else "ros2")
    assert code == 0
    for line in (
        "package Mocap was renamed to mocap",
        "type Mocap/msg/rigid_body was renamed to RigidBody",
        "field Mocap/rigid_body.timeStamp was renamed to time_stamp",
        "field Mocap/rigid_body.X was renamed to x2",
        "field Mocap/rigid_body.markerSets was renamed to marker_sets",
        "field Mocap/rigid_body.Corners_ was renamed to corners",
        "field Mocap/MarkerSet.setName was renamed to set_name",
        "field Mocap/MarkerSet.num__markers was renamed to num_markers",
    ):
        assert f"NOTE: {line}: ROS 2 does not allow the old name\n" in err
    assert len(err.splitlines()) == 8
    with AnyReader([tmp_path / output]) as reader:
        (connection,) = (each for each in reader.connections if each.topic == "/body")
        assert connection.msgtype == "mocap/msg/RigidBody"
        for line in re.findall(r"^(?!MSG:)[a-zA-Z]\S* +(\S+)$", connection.msgdef.data, re.MULTILINE):
            assert re.fullmatch(FIELD, line)
        ((_, _, data),) = reader.messages([connection])
        message: Any = reader.deserialize(data, connection.msgtype)
    assert (message.time_stamp.sec, message.x2, message.x, message.corners[1].y) == (5, 1.5, 2.5, 4.0)
    assert [(each.set_name, each.num_markers) for each in message.marker_sets] == [("s", 3)]
    assert run("import", output, "-o", "y.bag")[0] == 0
    with pyros1.bag.open("y.bag") as bag:
        found = {item.topic: item.message for item in bag.messages()}
    assert found["/body"]._type == "mocap/RigidBody"
    assert (found["/body"].time_stamp, found["/body"].marker_sets[0].set_name) == (Time(5, 6), "s")
    assert found["/text"].data == "hello"


def test_names_that_are_taken_get_numbers() -> None:
    names = LegalNames({"std_msgs/msg/String"})
    base = (Nodetype.BASE, ("int8", 0))
    made = names.legal_types(
        {
            "Pkg/msg/A": ([], [("aB", base), ("a_b", base), ("a__b", base)]),
            "pkg/msg/A": ([], [("other", (Nodetype.NAME, "Pkg/msg/A"))]),
            "pkg/msg/a": ([("X", "int8", 1), ("x", "int8", 2)], []),
            "std_msgs/msg/String": ([], [("Data", base)]),
        }
    )
    assert made == {
        "pkg2/msg/A": ([], [("a_b2", base), ("a_b", base), ("a_b3", base)]),
        "pkg/msg/A": ([], [("other", (Nodetype.NAME, "pkg2/msg/A"))]),
        "pkg/msg/A2": ([("X", "int8", 1), ("X2", "int8", 2)], []),
        "std_msgs/msg/String": ([], [("Data", base)]),
    }
    assert names.legal_types({"Pkg/msg/A": ([], [])}) == {"pkg2/msg/A": ([], [])}
    assert LegalNames({}).legal_type("fine_pkg/msg/Fine") == "fine_pkg/msg/Fine"
