"""The module rosbag: stock's and ours write and read the same bags, and answer the same.

Feature: `import rosbag` as in stock ROS: all modes, raw messages, connection headers, reindex, exceptions -- random bags
    and the recipes of the wiki's cookbook, compared with stock's module; writes 4 to 7 times, reads 3 times as many
    messages per second
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import faces
import pytest
from harness import Master

MASTERS = ("ours",)
pytestmark = pytest.mark.ours_only

SIGNATURES = """
import inspect, json, sys
import rosbag, rosbag.bag, rosbag.rosbag_main, rosbag.migration
def form(function):
    return [[p.name, p.kind.name, repr(p.default)] for p in inspect.signature(function).parameters.values()]
found = {}
for module in (rosbag.bag, rosbag.rosbag_main, rosbag.migration):
    for name, value in vars(module).items():
        if name.startswith("_") or inspect.ismodule(value) or getattr(value, "__module__", "") not in (module.__name__, "rosbag._progress"):
            continue
        if inspect.isfunction(value):
            found[module.__name__ + "." + name] = form(value)
        elif inspect.isclass(value):
            found[module.__name__ + "." + name] = form(value.__init__) if "__init__" in vars(value) else []
            for key in dir(value):
                member = inspect.getattr_static(value, key)
                if key.startswith("_") and not key.startswith(("_get_en", "_get_conn", "_read_m")):
                    continue
                if inspect.isfunction(member):
                    found[module.__name__ + "." + name + "." + key] = form(member)
                elif isinstance(member, property):
                    found[module.__name__ + "." + name + "." + key] = "property"
print(json.dumps(found))
"""

MIGRATOR = (
    "expand_rules", "filter_rules_unique", "find_path", "make_new_half_rule", "make_old_half_rule", "make_update_rule",
    "scaffold_range",
)  # fmt: skip
RULE = (
    "apply",
    "find_sub_paths",
    "get_class_def",
    "get_old_class",
    "get_new_class",
    "migrate_array",
    "update",
    "migrate",
)
LEFT_OUT = {
    "rosbag.rosbag_main.RosbagCmds",
    "rosbag.rosbag_main.bag_op",
    "rosbag.rosbag_main.change_compression_op",
    "rosbag.rosbag_main.change_encryption_op",
    "rosbag.rosbag_main.handle_pause_topics",
    "rosbag.rosbag_main.handle_split",
    "rosbag.rosbag_main.handle_topics",
    "rosbag.rosbag_main.print_trans",
    "rosbag.rosbag_main.reindex_op",
    "rosbag.bag.ComparableMixin",  # of which only the comparisons count
    *(f"rosbag.migration.MessageMigrator.{name}" for name in MIGRATOR),
    *(f"rosbag.migration.MessageUpdateRule.{name}" for name in RULE),
    "rosbag.migration.RuleChain",
    "rosbag.migration.ScaffoldNode",
    "rosbag.migration.constants_from_def",
    "rosbag.migration.migration_default_value",
}

WRITE = """
import random, sys
import genpy, rosbag
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import Imu, LaserScan
from std_msgs.msg import Bool, Float64MultiArray, Header, Int32, String, UInt8MultiArray
path, seed, mode, begin = sys.argv[1], int(sys.argv[2]), sys.argv[3], int(sys.argv[4])
draw = random.Random(seed)
def message(kind):
    if kind is String:
        return String("".join(draw.choice("abc \\u00e4\\u4e2d") for _ in range(draw.randrange(30))))
    if kind is Int32:
        return Int32(draw.randrange(-2**31, 2**31))
    if kind is Bool:
        return Bool(draw.random() < 0.5)
    if kind is Float64MultiArray:
        return Float64MultiArray(data=[draw.uniform(-1e9, 1e9) for _ in range(draw.randrange(20))])
    if kind is UInt8MultiArray:
        return UInt8MultiArray(data=bytes(draw.randrange(256) for _ in range(draw.choice([0, 3, 3000]))))
    if kind is Header:
        return Header(draw.randrange(2**32), genpy.Time(draw.randrange(2**32), draw.randrange(10**9)), "frame")
    made = kind()
    made.header.stamp = genpy.Time(draw.randrange(100), 5)
    made.header.seq = draw.randrange(1000)
    if kind is LaserScan:
        made.ranges = [draw.uniform(0, 10) for _ in range(draw.randrange(50))]
    return made
kinds = [String, Int32, Bool, Float64MultiArray, UInt8MultiArray, Header, Imu, LaserScan, PoseStamped]
options = [("/" if draw.random() < 0.8 else "") + name for name in ("a", "b", "ns/c", "d/", "e//f", "g")]
topics = {topic: draw.choice(kinds) for topic in options[: draw.randrange(1, 7)]}
compression = draw.choice(["none", "bz2", "lz4"])
stamps = [genpy.Time(begin + draw.randrange(10), draw.choice([0, 0, 5, 999999999])) for _ in range(draw.randrange(120))]
ordered = draw.random() < 0.6  # stock reads chunks that are out of order out of order
if ordered:
    stamps.sort()
threshold = draw.choice([0, 100, 5000, 768 * 1024]) if ordered else 768 * 1024
headers = {"callerid": "/writer", "latching": "1"}
with rosbag.Bag(path, mode, compression=compression, chunk_threshold=threshold) as bag:
    for stamp in stamps:
        topic = draw.choice(list(topics))
        kind = topics[topic]
        header = None
        if draw.random() < 0.2:
            header = dict(headers, topic=topic, type=kind._type, md5sum=kind._md5sum)
            header["message_definition"] = kind._full_text
        if draw.random() < 0.2:
            import io
            buffer = io.BytesIO()
            message(kind).serialize(buffer)
            bag.write(topic, (kind._type, buffer.getvalue(), kind._md5sum, kind), stamp, True, header)
        else:
            bag.write(topic, message(kind), stamp, connection_header=header)
        if ordered and draw.random() < 0.02:
            bag.compression = draw.choice(["none", "bz2", "lz4"])
        if ordered and draw.random() < 0.02:
            bag.flush()
"""

READ = """
import random, sys
import genpy, rosbag
def show(*items):
    print(*(repr(item).replace("genpy.Time", "Time").replace("rospy.Time", "Time") for item in items))
for path in sys.argv[1:]:
    with rosbag.Bag(path) as bag:
        print(str(bag)[: str(bag).find("compress")], bag.mode, bag.version, bag.size, bag.options)
        show(bag.get_message_count(), bag.get_type_and_topic_info(), bag.get_compression_info())
        print(bag._get_yaml_info())
        show(bag._uncompressed_size, bag._has_compressed_chunks)
        try:
            show(bag.get_start_time(), bag.get_end_time())
        except rosbag.ROSBagException as error:
            print(type(error).__module__, type(error).__name__, error)
        for topic, message, stamp, header in bag.read_messages(return_connection_header=True):
            show(topic, message._type, message._md5sum, str(message), stamp, sorted(header.items()))
        for topic, (kind, data, md5sum, position, cls), stamp in bag.read_messages(raw=True):
            show(topic, kind, data, md5sum, cls._type, cls._md5sum, stamp, bag._read_message(position).topic)
        draw = random.Random(1)
        topics = sorted(bag.get_type_and_topic_info().topics) + ["/not/there"]
        for _ in range(30):
            some = draw.sample(topics, min(2, len(topics)))
            wanted = draw.choice([None, draw.choice(topics), some, [], tuple(topics)])
            times = [draw.choice([None, genpy.Time(draw.randrange(18, 32), draw.choice([0, 5]))]) for _ in range(2)]
            odd = draw.random() < 0.3
            def chosen(topic, datatype, md5sum, msg_def, header):
                return len(topic) % 2 == 0 and header["type"] == datatype.encode() and md5sum and msg_def is not None
            found = bag.read_messages(wanted, *times, connection_filter=chosen if odd else None)
            show(wanted, times, [(topic, str(stamp), str(message)[:20]) for topic, message, stamp in found])
            show(bag.get_message_count(wanted))
        show([(str(entry), entry.position, str(entry.time)) for entry in bag._get_entries()])
        moment = genpy.Time(25, 1)
        show([str(bag._get_entry(moment, list(bag._get_connections(topic)))) for topic in topics[:-1]])
        show([str(bag._get_entry_after(moment, list(bag._get_connections(topic)))) for topic in topics[:-1]])
        show([(each.id, each.topic, each.datatype, each.md5sum) for each in bag._get_connections()])
"""


def test_signatures_are_stocks(master: Master) -> None:
    stock, ours = (json.loads(faces.run(face, master, SIGNATURES)) for face in faces.FACES)
    wanted = {
        name: form for name, form in stock.items() if not any(f"{name}.".startswith(f"{out}.") for out in LEFT_OUT)
    }
    assert {name: ours.get(name) for name in wanted} == wanted


@pytest.mark.parametrize("seed", range(12))
def test_bags_of_both_are_read_alike_by_both(master: Master, tmp_path: Path, seed: int) -> None:
    for face in faces.FACES:
        faces.run(face, master, WRITE, str(tmp_path / f"{face}.bag"), str(seed), "w", "20")
    faces.same(master, READ, str(tmp_path / "stock.bag"), str(tmp_path / "ours.bag"))


def test_chunks_out_of_order_hold_the_same(master: Master, tmp_path: Path) -> None:
    """Stock then yields messages in another order than that of time, and we in that of time."""
    path = str(tmp_path / "x.bag")
    faces.run("ours", master, WRITE, path, "3", "w", "40")
    faces.run("stock", master, WRITE, path, "4", "a", "20")
    stock, ours = (faces.run(face, master, ALL, path).splitlines() for face in faces.FACES)
    assert sorted(stock) == sorted(ours) and len(ours) > 20
    stamps = [line.split()[0] for line in ours]
    assert stamps == sorted(stamps)


ALL = """
import sys
import rosbag
for topic, message, stamp in rosbag.Bag(sys.argv[1]):
    print(str(stamp).zfill(20), topic, type(message)._md5sum, str(message).replace("\\n", " ")[:100])
"""


def test_both_append_to_bags_of_both(master: Master, tmp_path: Path) -> None:
    paths = []
    for number, (first, second) in enumerate([("stock", "ours"), ("ours", "stock"), ("ours", "ours")]):
        path = str(tmp_path / f"{number}.bag")
        faces.run(first, master, WRITE, path, "3", "w", "20")
        faces.run(second, master, WRITE, path, "4", "a", "40")
        paths.append(path)
    faces.same(master, READ, *paths)


def test_bags_from_elsewhere_are_read_alike(master: Master, tmp_path: Path) -> None:
    """Those in the folder that ``PYROS1_BAGS`` names, and one that stock makes."""
    faces.run("stock", master, WRITE, str(tmp_path / "stock.bag"), "5", "w", "20")
    folders = [tmp_path, *map(Path, filter(None, [os.environ.get("PYROS1_BAGS")]))]
    found = [path for folder in folders for path in sorted(folder.glob("*.bag"))]
    bags = [path for path in found if path.stat().st_size < 5 << 20]
    paths = [str(path) for path in bags if path.read_bytes()[:13] == b"#ROSBAG V2.0\n"]
    stock, ours = (faces.run(face, master, TOLERANT, *paths, timeout=300).split("BAG ") for face in faces.FACES)
    for one, other in zip(stock, ours, strict=True):
        assert sorted(one.splitlines()) == sorted(other.splitlines())


def test_topics_are_chosen_by_name_alike(master: Master, tmp_path: Path) -> None:
    faces.same(master, BY_NAME, str(tmp_path / "names.bag"))


BY_NAME = """
import random, sys
import rosbag, rospy
from std_msgs.msg import Int32
topics = ["chatter", "/chatter", "a/b", "/a/b", "/a//b", "/a/b/", "a//b", "~p", "x-y z", "/", "n/rel", "/N"]
rng = random.Random(7)
with rosbag.Bag(sys.argv[1], "w") as bag:
    for number in range(40):
        bag.write(rng.choice(topics), Int32(number), rospy.Time(number + 1))
asked = [*topics, "chatter/", "//chatter", "b", "", "/n/rel", "N", "/chatter/data"]
asked += [rng.sample(asked, 3) for _ in range(20)] + [tuple(asked[:2]), set(asked[:3]), []]
with rosbag.Bag(sys.argv[1]) as bag:
    for names in asked:
        print(names if isinstance(names, (str, list)) else sorted(names))
        print([(topic, message.data) for topic, message, _ in bag.read_messages(names)])
        for ask in (bag.get_message_count, bag.get_type_and_topic_info):
            try:
                print(ask(names))
            except Exception as error:
                print(type(error).__name__)
"""

TOLERANT = """
import sys
import rosbag
for path in sys.argv[1:]:
    print("BAG", path)
    try:
        with rosbag.Bag(path) as bag:
            print(bag.get_message_count(), bag.get_type_and_topic_info())
            for topic, message, stamp in bag.read_messages():
                print(topic, stamp, message._md5sum)  # of types with the same sum stock takes one for the other
                print(str(message)[:500])
    except rosbag.ROSBagUnindexedException as error:
        print(type(error).__name__, error)
"""

ANSWERS = """
import io, os, pickle, sys
import genpy, rosbag
from std_msgs.msg import Int32, String
Time = genpy.Time
os.chdir(sys.argv[1])
def ask(function, *arguments, **named):
    try:
        print("->", repr(function(*arguments, **named)).partition(" at 0x")[0])
    except Exception as error:
        print(type(error).__module__, type(error).__name__, repr(str(error)))
bag = rosbag.Bag("a.bag", "w")
print(bag.options, bag.filename, bag.version, bag.mode, bag.compression, bag.chunk_threshold)
bag.write("/a", String("x"), Time(10, 5))
ask(bag.write, "", String("x"))
ask(bag.write, "/a", None)
ask(bag.write, "/a", ("a", "b"), raw=True)
ask(bag.write, "/b", ("not_there/Type", b"", "md5", None), Time(1), raw=True)
ask(setattr, bag, "compression", "zip")
ask(setattr, bag, "chunk_threshold", -1)
bag.close()
bag.close()
ask(bag.write, "/a", String("x"))
for function in (bag.flush, bag.read_messages, lambda: bag.size, lambda: str(bag)):
    ask(function)
ask(bag.get_message_count)
ask(bag.get_start_time)
ask(bag.get_compression_info)
ask(bag.get_type_and_topic_info)
bag = rosbag.Bag("a.bag")
ask(bag.write, "/a", String("x"))
ask(lambda: list(bag.read_messages(start_time=1)))
ask(bag._get_yaml_info, "start")
ask(bag._get_yaml_info, "topics")
ask(lambda: [rosbag.bag._get_message_type(each)._type for each in bag._get_connections()])
ask(lambda: {key: value._type for key, value in rosbag.bag._message_types.items()})
bag.close()
ask(rosbag.Bag, "not_there.bag")
ask(rosbag.Bag, "a.bag", "x")
ask(rosbag.Bag, None)
ask(rosbag.Bag, "")
ask(rosbag.Bag, "b.bag", "w", compression="zip")
ask(rosbag.Bag, "b.bag", "w", chunk_threshold=-1)
ask(rosbag.Bag, "b.bag", "w", options=5)
ask(rosbag.Bag, "no/folder/b.bag", "w")
for name, text in [("empty", b""), ("other", b"hello\\nworld"), ("future", b"#ROSBAG V3.0\\n")]:
    with open(name, "wb") as file:
        file.write(text)
    ask(rosbag.Bag, name)
    ask(rosbag.Bag, name, "a")
whole = open("a.bag", "rb").read()
open("cut.bag", "wb").write(whole[:-50])
ask(rosbag.Bag, "cut.bag")
for error in (rosbag.ROSBagException("text"), rosbag.ROSBagUnindexedException(), rosbag.ROSBagFormatException("text")):
    print(repr(error), str(error), error.value, repr(pickle.loads(pickle.dumps(error))))
for name in ("ROSBagEncryptException", "ROSBagEncryptNotSupportedException", "ROSBagFormatException"):
    print(issubclass(getattr(rosbag.bag, name), rosbag.ROSBagException))
empty = rosbag.Bag("new.bag", "w")
empty.close()
with rosbag.Bag("new.bag") as bag:
    print(list(bag), bag, bag.get_message_count(), bag.get_type_and_topic_info(), bag.get_compression_info())
    ask(bag.get_start_time)
with open("f.bag", "w+b") as file:
    bag = rosbag.Bag(file, "w")
    bag.write("/a", String("y"), Time(3))
    print(bag.filename)
    bag.close()
    print(file.closed)
with open("f.bag", "rb") as file:
    bag = rosbag.Bag(file)
    print([message.data for _, message, _ in bag])
    bag.close()
    print(file.closed)
try:
    with rosbag.Bag("w.bag", "w") as bag:
        bag.write("/a", String("x"), Time(4))
        raise KeyError
except KeyError:
    print(len(list(rosbag.Bag("w.bag"))))
class Own:
    _type, _md5sum, _full_text = String._type, String._md5sum, "string data"
    def serialize(self, buffer):
        buffer.write(b"\\2\\0\\0\\0zz")
with rosbag.Bag("o.bag", "w") as bag:
    bag.write("/own", Own(), Time(1))
print([message.data for _, message, _ in rosbag.Bag("o.bag")])
message = next(iter(rosbag.Bag("o.bag")))
print(message._fields, message.topic, message.timestamp, type(message).__name__)
print(isinstance(message.timestamp, genpy.Time))
"""


def test_answers_and_exceptions(master: Master, tmp_path: Path) -> None:
    outputs = []
    for face in faces.FACES:
        (tmp_path / face).mkdir()
        outputs.append(faces.run(face, master, ANSWERS, str(tmp_path / face)))
    assert outputs[1] == outputs[0]


REINDEX = """
import shutil, sys
import genpy, rosbag
from std_msgs.msg import Int32
path = sys.argv[1]
bag = rosbag.Bag(path, "w", chunk_threshold=1)
for number in range(5):
    bag.write("/a", Int32(number), genpy.Time(number + 1))
bag._file.flush() if hasattr(bag._file, "flush") else None
shutil.copy(path, path + ".part")
bag.close()
for mode in ("r", "a"):
    try:
        rosbag.Bag(path + ".part", mode)
    except rosbag.ROSBagUnindexedException as error:
        print(error)
with rosbag.Bag(path + ".part", allow_unindexed=True) as bag:
    print(list(bag), bag.get_message_count())
    print(list(bag.reindex()))
    print(sorted({message.data for _, message, _ in bag}))  # stock yields each twice
with rosbag.Bag(path + ".part", "a", allow_unindexed=True) as bag:
    for offset in bag.reindex():
        print(offset)
with rosbag.Bag(path + ".part") as bag:
    print([message.data for _, message, _ in bag], bag.get_message_count(), list(bag.reindex()))
"""


def test_reindexing(master: Master, tmp_path: Path) -> None:
    outputs = [faces.run(face, master, REINDEX, str(tmp_path / f"{face}.bag")) for face in faces.FACES]
    assert outputs[1] == outputs[0]


MIGRATION = """
import sys
import genpy, rosbag
import rosbag.migration as migration
import rosbag.rosbag_main
from std_msgs.msg import Bool, Int32, String
path, other = sys.argv[1:]
with rosbag.Bag(path, "w") as bag:
    bag.write("/a", String("x"), genpy.Time(1))
    bag.write("/b", Int32(5), genpy.Time(2), connection_header={
        "topic": "/b", "type": "std_msgs/Int32", "md5sum": Int32._md5sum, "message_definition": Int32._full_text,
        "callerid": "/me"})
migrator = migration.MessageMigrator()
print(migrator.all_rules_valid(), migrator.get_invalid_rules(), migrator.find_target(String)._type)
print(migration.checkbag(migrator, path), migration.checkmessages(migrator, [String("x")]))
print(migration.fixbag(migrator, path, other), migration.fixbag2(migrator, path, other, True))
print([(topic, str(message), str(stamp)) for topic, message, stamp in rosbag.Bag(other)])
copy = String()
migrator.migrate(String("text"), copy)
copies = [String(), String()]
migrator.migrate_array([String("1"), String("2")], copies)
print(copy.data, [each.data for each in copies])
for name in ("String", "std_msgs/String", "Header", "int32", "std_msgs/Header", "other/String", "time"):
    print(migration.qualified_name(name, "std_msgs/Bool"), migration.clean_name(name, "std_msgs/Bool"))
print(migration.get_message_key(String), migration.get_path_key(String, Int32))
with rosbag.Bag(path) as bag, rosbag.Bag(other, "w") as out:
    out.compression = "bz2"
    for topic, message, stamp, header in bag.read_messages(raw=True, return_connection_header=True):
        out.write(topic, message, stamp, raw=True, connection_header=header)
with rosbag.Bag(other) as bag:
    print(bag.get_compression_info().compression, bag.get_message_count())
    print([header.get("callerid") for _, _, _, header in bag.read_messages(return_connection_header=True)])
"""


def test_migration_and_operations(master: Master, tmp_path: Path) -> None:
    outputs = [
        faces.run(face, master, MIGRATION, str(tmp_path / f"{face}.bag"), str(tmp_path / f"{face}2.bag"))
        for face in faces.FACES
    ]
    assert outputs[1] == outputs[0]
