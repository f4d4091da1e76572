"""rosbag by pyros1, in programs as users write them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from programs import run

BAG = """
import os, sys
import genpy, rosbag, rospy
from std_msgs.msg import Int32, String
from sensor_msgs.msg import Imu
os.chdir(sys.argv[1])
def refused(function, *arguments, **named):
    try:
        function(*arguments, **named)
    except Exception as error:
        return type(error).__name__, str(error)
    raise AssertionError("not refused")
"""

MODES = """
with rosbag.Bag("a.bag", "w", compression="lz4", chunk_threshold=100) as bag:
    for number in range(20):
        bag.write("/number", Int32(number), genpy.Time(100 + number))
        bag.write("/text", String(str(number)), rospy.Time(100 + number))
    assert bag.get_message_count() == 40 and bag.mode == "w"
    assert [message.data for _, message, _ in bag.read_messages("/number")] == list(range(20))  # while it is written
    bag.write("/number", Int32(20), genpy.Time(120))
    assert bag.get_end_time() == 120.0
with rosbag.Bag("a.bag", "a") as bag:
    bag.write("/number", Int32(21), genpy.Time(121))
    assert bag.get_message_count(["/number"]) == 22
bag = rosbag.Bag("a.bag")
topic, message, stamp = next(bag.read_messages(start_time=genpy.Time(110), topics=["/text"]))
assert (topic, message.data) == ("/text", "10") and isinstance(stamp, rospy.Time) and stamp.to_sec() == 110.0
assert isinstance(message, genpy.Message) and message._type == "std_msgs/String"
assert bag.get_compression_info().compression == "lz4"
bag.close()
assert refused(bag.read_messages) == ("ValueError", "I/O operation on closed bag")
assert refused(rosbag.Bag, "a.bag", "x") == ("ValueError", 'mode "x" is invalid')
print("done")
"""

UNFINISHED = """
bag = rosbag.Bag("a.bag", "w", chunk_threshold=0)
for number in range(5):
    bag.write("/number", Int32(number), genpy.Time(number + 1))
open("b.bag", "wb").write(open("a.bag", "rb").read())
bag.close()
assert refused(rosbag.Bag, "b.bag") == ("ROSBagUnindexedException", "Unindexed bag")
with rosbag.Bag("b.bag", allow_unindexed=True) as bag:
    assert not list(bag) and len(list(bag.reindex())) == 5 and len(list(bag)) == 5
with rosbag.Bag("b.bag", "a", allow_unindexed=True) as bag:
    for offset in bag.reindex():
        assert offset > 0
    bag.write("/number", Int32(5), genpy.Time(6))
assert [message.data for _, message, _ in rosbag.Bag("b.bag")] == list(range(6))

# An index that lies: the first chunk is not there.
data = open("b.bag", "rb").read()
place = data.index(b"chunk_pos=") + 10
open("b.bag", "wb").write(data[:place] + bytes([255]) * 7 + bytes([0]) + data[place + 8:])
assert refused(list, rosbag.Bag("b.bag"))[0] == "ROSBagFormatException"
with rosbag.Bag("b.bag", "a") as bag:
    assert max(bag.reindex()) < bag.size
    bag.write("/number", Int32(6), genpy.Time(7))
assert [message.data for _, message, _ in rosbag.Bag("b.bag")] == list(range(7))
print("done")
"""

TYPES = """
class Own:
    _type, _md5sum, _full_text = "own_msgs/Pair", "*", "int32 a\\nint32 b"
    def serialize(self, buffer):
        buffer.write(bytes([1, 0, 0, 0, 2, 0, 0, 0]))
with rosbag.Bag("a.bag", "w") as bag:
    bag.write("/t", Own(), genpy.Time(1))
    bag.write("/t", String("x"), genpy.Time(2))  # another type on the same topic gets a connection of its own
    assert refused(bag.write, "/t", String(5), genpy.Time(3))[0] == "SerializationError"
    assert refused(bag.write, "/t", rospy.AnyMsg(), genpy.Time(3))[0] in ("ValueError", "ROSException")
    assert refused(bag.set_encryptor, "other/Encryptor")[0] == "ROSBagEncryptNotSupportedException"
    assert refused(bag.set_encryptor, "rosbag/AesCbcEncryptor")[0] == "ROSBagException"  # it holds messages already
    bag.set_encryptor()
    assert refused(bag.write, "/u", String("x"), genpy.Time(3), connection_header={"topic": "/u"}) == (
        "ROSBagFormatException", 'expected "type" field in record')
pair, text = [message for _, message, _ in rosbag.Bag("a.bag")]
assert (pair.a, pair.b, text.data) == (1, 2, "x")
with rosbag.Bag("a.bag") as source, rosbag.Bag("b.bag", "w") as target:
    for topic, message, stamp in source.read_messages(raw=True):
        assert len(message) == 5 and message[4]._type == message[0]
        target.write(topic, message, stamp, raw=True)
assert [str(message) for _, message, _ in rosbag.Bag("b.bag")] == [str(pair), str(text)]
print("done")
"""

THREADS = """
import threading
with rosbag.Bag("a.bag", "w", chunk_threshold=300) as bag:
    def write(topic):
        for number in range(300):
            bag.write(topic, Int32(number), genpy.Time(number + 1))
    threads = [threading.Thread(target=write, args=("/t%d" % number,)) for number in range(4)]
    [thread.start() for thread in threads]
    [thread.join(30) for thread in threads]
with rosbag.Bag("a.bag") as bag:
    for number in range(4):
        assert [message.data for _, message, _ in bag.read_messages("/t%d" % number)] == list(range(300))
print("done")
"""

TOOL = """
import rosbag.bag, rosbag.migration, rosbag.rosbag_main
with rosbag.Bag("a.bag", "w", compression="bz2") as bag:
    bag.write("/number", Int32(1), genpy.Time(1))
rosbag.rosbag_main.decompress_cmd(["-q", "a.bag"])
assert rosbag.Bag("a.bag").get_compression_info().compression == "none"
rosbag.rosbag_main.info_cmd(["-y", "-k", "messages", "a.bag"])
rosbag.rosbagmain(["rosbag", "check", "a.bag"])
try:
    rosbag.rosbag_main.info_cmd(["not_there.bag"])
except SystemExit as error:
    assert error.code == 1
migrator = rosbag.migration.MessageMigrator()
assert rosbag.migration.checkbag(migrator, "a.bag") == [] and rosbag.migration.fixbag(migrator, "a.bag", "b.bag")
assert rosbag.Bag("b.bag").get_message_count() == 1
print("done")
"""


def test_modes(tmp_path: Path) -> None:
    assert run(BAG + MODES, {}, str(tmp_path)) == "done\n"


def test_bags_that_were_not_closed(tmp_path: Path) -> None:
    assert run(BAG + UNFINISHED, {}, str(tmp_path)) == "done\n"


def test_types_and_raw_messages(tmp_path: Path) -> None:
    assert run(BAG + TYPES, {}, str(tmp_path)) == "done\n"


def test_threads_write_at_once(tmp_path: Path) -> None:
    assert run(BAG + THREADS, {}, str(tmp_path)) == "done\n"


ASKED = """
import threading
with rosbag.Bag("a.bag", "w", chunk_threshold=50) as bag:
    bag.write("/number", Int32(0), genpy.Time(1))
    def write():
        for _ in range(300):
            bag.write("/number", Int32(1), genpy.Time(1))
            bag.get_message_count()
    thread = threading.Thread(target=write)
    thread.start()
    while thread.is_alive():
        bag.get_type_and_topic_info()
        bag.get_compression_info()
print("done")
"""


@pytest.mark.slow
def test_it_is_asked_while_another_thread_writes(tmp_path: Path) -> None:
    assert run(BAG + ASKED, {}, str(tmp_path)) == "done\n"


def test_the_tool_and_migration(tmp_path: Path) -> None:
    said = run(BAG + TOOL, {}, str(tmp_path))
    assert said.endswith("done\n") and "\n1\n" in f"\n{said}" and "does not need any migrations" in said


MEANWHILE = """
with rosbag.Bag("a.bag", "w", chunk_threshold=100) as bag:
    for number in range(50):
        bag.write("/number", Int32(number), genpy.Time(1 + number))
    copied = 0
    for _, message, stamp in bag.read_messages("/number"):
        bag.write("/copy", message, stamp)
        copied += 1
        assert sum(1 for _ in bag.read_messages("/copy")) == copied == bag.get_message_count("/copy")
    assert copied == 50
with rosbag.Bag("a.bag") as bag:
    assert bag.get_message_count() == 100
print("done")
"""


def test_a_bag_is_written_and_read_while_an_iterator_is_in_its_middle(tmp_path: Path) -> None:
    assert run(BAG + MEANWHILE, {}, str(tmp_path)) == "done\n"


PICKLED = """
import copy, pickle
from multiprocessing import get_context
import genpy.dynamic
from geometry_msgs.msg import PolygonStamped, Point32
with rosbag.Bag("a.bag", "w") as bag:
    message = PolygonStamped()
    message.header.frame_id = "map"
    message.polygon.points.append(Point32(1, 2, 3))
    bag.write("/area", message, genpy.Time(1))
_, read, _ = next(rosbag.Bag("a.bag").read_messages())
again = pickle.loads(pickle.dumps(read))
assert type(again) is type(read) and again == read == copy.deepcopy(read)
with get_context("fork").Pool(1) as pool:
    assert pool.map(copy.copy, [read]) == [read]
text = "std_msgs/Header header\\n" + "=" * 80 + "\\nMSG: std_msgs/Header\\nuint32 seq\\ntime stamp\\nstring frame_id\\n"
for cls in (genpy.dynamic.generate_dynamic("my_msgs/A", text)["my_msgs/A"] for _ in range(2)):
    value = cls()
    value.header.frame_id = "odom"
    assert pickle.loads(pickle.dumps(value)) == value
print("done")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_messages_of_definitions_in_bags_are_pickled(tmp_path: Path) -> None:
    assert run(BAG + PICKLED, {}, str(tmp_path)) == "done\n"
