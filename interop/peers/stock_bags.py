"""Makes bags with stock rosbag in a folder: `stock_bags.py FOLDER`. Run by the system's Python."""

import sys
from pathlib import Path

import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import Header, Int32, String


def connection(message_class, **more):
    """A connection header."""
    return {
        "type": message_class._type,
        "md5sum": message_class._md5sum,
        "message_definition": message_class._full_text,
        **more,
    }


def fill(bag, count):
    """Three topics, one of them from two publishers."""
    one = connection(String, topic="/chatter", callerid="/one", latching="1")
    two = connection(String, topic="/chatter", callerid="/two")
    for i in range(count):
        at = rospy.Time(1000 + i // 50, (i % 50) * 20000000)
        bag.write("/chatter", String(f"text {i}"), at, connection_header=one if i % 3 else two)
        bag.write("/number", Int32(i), at + rospy.Duration(0, 1000))
        if i % 10 == 0:
            bag.write("tf", TransformStamped(Header(i, at, "map"), "base", TransformStamped().transform), at)


def main(folder):
    """Write the bags."""
    for name, options, count in (
        ("plain", {}, 500),
        ("bz2", {"compression": "bz2", "chunk_threshold": 5000}, 500),
        ("lz4", {"compression": "lz4", "chunk_threshold": 5000}, 500),
        ("long", {"chunk_threshold": 10000}, 8000),
        ("empty", {}, 0),
        ("single", {}, 1),
    ):
        with rosbag.Bag(str(folder / (name + ".bag")), "w", **options) as bag:
            fill(bag, count)
    with rosbag.Bag(str(folder / "mixed.bag"), "w", chunk_threshold=3000) as bag:
        for compression in ("none", "bz2", "lz4", "bz2"):
            bag.compression = compression
            fill(bag, 60)
            bag.flush()
    data = (folder / "lz4.bag").read_bytes()
    (folder / "cut.bag").write_bytes(data[: len(data) // 2])
    data = (folder / "plain.bag").read_bytes()
    (folder / "noindex.bag").write_bytes(data[:-100])
    (folder / "zero.bag").write_bytes(b"")
    (folder / "foreign.bag").write_text("hello")


def dump(path):
    """Print every message of a bag, and every connection header, as stock reads them."""
    with rosbag.Bag(path) as bag:
        for topic, message, at, header in bag.read_messages(raw=True, return_connection_header=True):
            print(at.to_nsec(), topic, message[0], message[2], message[1].hex(), sorted(header.items()))


if __name__ == "__main__":
    if sys.argv[1] == "dump":
        dump(sys.argv[2])
    else:
        main(Path(sys.argv[1]))
