"""What programs do with rosbag: recipes as in the wiki's cookbook, on stock's module and ours.

Feature: `import rosbag` as in stock ROS: all modes, raw messages, connection headers, reindex, exceptions
"""

from __future__ import annotations

from pathlib import Path

import faces
import pytest
from harness import Master

MASTERS = ("ours",)
pytestmark = pytest.mark.ours_only

MAKE = """
import sys
import genpy, rosbag
from geometry_msgs.msg import Twist, TransformStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
with rosbag.Bag(sys.argv[1], "w", compression=sys.argv[2], chunk_threshold=4000) as bag:
    for number in range(200):
        stamp = genpy.Time(1000 + number // 10, number % 10 * 100000000)
        odometry = Odometry()
        odometry.header.stamp = genpy.Time(1000 + number // 10, 7)
        odometry.header.seq = number
        odometry.child_frame_id = "base"
        odometry.pose.pose.position.x = number / 7
        odometry.twist.twist.angular.z = -number
        bag.write("/odom", odometry, stamp)
        if number % 3 == 0:
            twist = Twist()
            twist.linear.x = number
            bag.write("/cmd_vel", twist, t=stamp)
        if number % 5 == 0:
            step = TransformStamped()
            step.header.stamp = genpy.Time(1000 + number // 10, 3)
            step.header.frame_id, step.child_frame_id = "odom", "base" if number % 2 else "arm"
            step.transform.rotation.w = 1
            bag.write("/tf", TFMessage([step]), stamp)
    bag.write("/note", String("the end"), genpy.Time(1020))
"""

RECIPES = {
    "other stamps": """
with rosbag.Bag(target, "w") as out:
    for topic, message, stamp in rosbag.Bag(source).read_messages():
        if topic == "/tf" and message.transforms:
            out.write(topic, message, message.transforms[0].header.stamp)
        else:
            out.write(topic, message, message.header.stamp if message._has_header else stamp)
""",
    "some topics and some time": """
with rosbag.Bag(target, "w", compression=rosbag.Compression.BZ2) as out:
    with rosbag.Bag(source) as bag:
        begin = genpy.Time.from_sec(bag.get_start_time() + 2.5)
        end = genpy.Time.from_sec(bag.get_end_time() - 3)
        for topic, message, stamp in bag.read_messages(topics=["/odom", "/tf"], start_time=begin, end_time=end):
            out.write(topic, message, stamp)
""",
    "raw, to other names": """
with rosbag.Bag(source) as bag, rosbag.Bag(target, "w") as out:
    for topic, message, stamp, header in bag.read_messages(raw=True, return_connection_header=True):
        header = dict(header)
        header["topic"] = "/robot" + topic
        out.write("/robot" + topic, message, stamp, raw=True, connection_header=header)
""",
    "transforms without a frame": """
with rosbag.Bag(source) as bag, rosbag.Bag(target, "w", options=bag.options) as out:
    for topic, message, stamp in bag:
        if topic == "/tf":
            message.transforms = [each for each in message.transforms if each.child_frame_id != "arm"]
            if not message.transforms:
                continue
        out.write(topic, message, stamp)
""",
    "a note behind the end": """
import shutil
shutil.copy(source, target)
with rosbag.Bag(target, "a") as bag:
    last = genpy.Time.from_sec(bag.get_end_time())
    note = String()
    note.data = "recorded on a Monday"
    bag.write("/metadata", note, last + genpy.Duration(1))
""",
    "two bags as one": """
with rosbag.Bag(target, "w") as out:
    for offset in (0, 100):
        with rosbag.Bag(source) as bag:
            for topic, message, stamp in bag.read_messages():
                out.write(topic, message, stamp + genpy.Duration.from_sec(offset))
""",
    "a chunk per message": """
with rosbag.Bag(target, "w", chunk_threshold=0) as out:
    for topic, message, stamp in rosbag.Bag(source).read_messages("/cmd_vel"):
        out.write(topic, message, stamp)
        out.flush()
""",
}

HEAD = """
import os, sys, time
os.environ["TZ"] = "UTC"
time.tzset()
import genpy, rosbag
from std_msgs.msg import String
source, target = sys.argv[1:]
"""

TABLES = """
with rosbag.Bag(source) as bag:
    types, topics = bag.get_type_and_topic_info()
    print(types)
    for name, info in sorted(topics.items()):
        print(name, info.msg_type, info.message_count, info.connections, info.frequency)
    def fields(message, before=""):
        for name, kind in zip(message.__slots__, message._slot_types):
            value = getattr(message, name)
            if hasattr(value, "__slots__") and not isinstance(value, genpy.rostime.TVal):
                yield from fields(value, before + name + ".")
            elif isinstance(value, genpy.rostime.TVal):
                yield before + name, value.to_sec()
            elif isinstance(value, (list, tuple)):
                for number, each in enumerate(value):
                    if hasattr(each, "__slots__"):
                        yield from fields(each, before + name + "[%d]." % number)
                    else:
                        yield before + name + "[%d]" % number, each
            else:
                yield before + name, value
    for topic in sorted(topics):
        columns = {}
        for _, message, stamp in bag.read_messages(topics=[topic]):
            columns.setdefault("time", []).append(stamp.to_time())
            for path, value in fields(message):
                columns.setdefault(path, []).append(value)
        print(topic)
        for path, values in sorted(columns.items()):
            print(path, len(values), values[:5], values[-1])
    before = None
    gaps = []
    for _, _, stamp in bag.read_messages("/odom"):
        if before is not None:
            gaps.append((stamp - before).to_sec())
        before = stamp
    print(max(gaps), min(gaps), bag.get_end_time() - bag.get_start_time())
    print(yaml.safe_load(bag._get_yaml_info())["duration"], bag)
    print(bag.get_message_count(["/odom", "/tf"]), bag.get_compression_info().compression)
"""

SHOW = """
with rosbag.Bag(target) as bag:
    print(bag.get_type_and_topic_info())
    for topic, message, stamp, header in bag.read_messages(return_connection_header=True):
        print(topic, stamp, str(message), header["topic"], header["type"], header["md5sum"])
"""


@pytest.fixture(scope="module")
def source(master: Master, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Bags with the same messages, made by stock and by us."""
    folder = tmp_path_factory.mktemp("recipes")
    made = {"stock": str(folder / "stock.bag"), "ours": str(folder / "ours.bag")}
    for face, path in made.items():
        faces.run(face, master, MAKE, path, "lz4" if face == "stock" else "bz2")
    return made


@pytest.mark.parametrize("name", RECIPES)
def test_a_recipe(master: Master, source: dict[str, str], tmp_path: Path, name: str) -> None:
    """Each on a bag of the other; then stock reads both results."""
    shown = []
    for face, other in zip(faces.FACES, faces.FACES[::-1], strict=True):
        target = str(tmp_path / f"{face}.bag")
        faces.run(face, master, HEAD + RECIPES[name], source[other], target)
        shown.append(faces.run("stock", master, HEAD + SHOW, "", target))
    assert shown[0] == shown[1]
    assert shown[0].count("\n") > 20


def test_tables(master: Master, source: dict[str, str]) -> None:
    for path in source.values():
        faces.same(master, "import yaml" + HEAD + TABLES, path, "")
