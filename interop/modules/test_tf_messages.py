"""tf2_geometry_msgs, tf2_sensor_msgs and laser_geometry of stock and ours: random messages, the same results."""

from __future__ import annotations

from faces import same
from harness import Master

MASTERS = ("ours",)  # these programs need no master; the fixture gives their environment

START = '''
import math, random, struct
import rospy, tf2_ros
from geometry_msgs.msg import *
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_msgs.msg import Header

def shown(value):
    """Numbers to eight digits, since the last bits depend on the order of operations."""
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(map(shown, value)) + ")"
    if isinstance(value, float):
        return "%.8f" % (value + 0.0 if abs(value) > 1e-9 else 0.0)
    if hasattr(value, "to_nsec"):
        return "%s ns" % value.to_nsec()
    if hasattr(value, "__slots__") and hasattr(value, "_slot_types"):
        fields = ((name, getattr(value, name)) for name in value.__slots__)
        return type(value).__name__ + "{" + ", ".join("%s: %s" % (name, shown(part)) for name, part in fields) + "}"
    return str(value)

chance = random.Random(9)

def vector(kind=Vector3):
    return kind(*[chance.choice([0.0, 1.0, chance.uniform(-9, 9)]) for _ in range(3)])

def quaternion():
    parts = [chance.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(part * part for part in parts))
    kind = chance.random()
    if kind < 0.1:
        return Quaternion(*chance.choice([(0, 0, 0, 0), (0, 0, 0, 1), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, -1, 0)]))
    if kind < 0.8:
        parts = [part / length for part in parts]
    return Quaternion(*parts)

def header(frame):
    return Header(chance.randrange(9), rospy.Time(chance.randrange(9), 5), frame)

def transform():
    return TransformStamped(header("map"), "base", Transform(vector(), quaternion()))

def table(cloud):
    kinds = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d"}
    print(shown(cloud.header), cloud.height, cloud.width, cloud.point_step, cloud.row_step, cloud.is_dense,
          cloud.is_bigendian, [(f.name, f.offset, f.datatype, f.count) for f in cloud.fields], len(cloud.data))
    for row in range(cloud.width):
        start = row * cloud.point_step
        for f in cloud.fields:
            numbers = struct.unpack_from("<%d%s" % (f.count, kinds[f.datatype]), cloud.data, start + f.offset)
            print(*["%.4f" % number for number in numbers], end=" ")
        print()
'''

GEOMETRY = (
    START
    + """
from tf2_geometry_msgs import do_transform_point, do_transform_pose, do_transform_vector3, do_transform_wrench
import tf2_geometry_msgs

for _ in range(400):
    print(shown(do_transform_point(PointStamped(header("base"), vector(Point)), transform())))
    print(shown(do_transform_vector3(Vector3Stamped(header("base"), vector()), transform())))
    print(shown(do_transform_pose(PoseStamped(header("base"), Pose(vector(Point), quaternion())), transform())))
    print(shown(do_transform_wrench(WrenchStamped(header("base"), Wrench(vector(), vector())), transform())))
buffer = tf2_ros.Buffer(debug=False)
for child in ("odom", "base"):
    for second in (1, 2):
        moved = Transform(vector(), Quaternion(0, 0, 0.6, 0.8))
        buffer.set_transform(TransformStamped(Header(0, rospy.Time(second), "map"), child, moved), "me")
for message in (PointStamped, PoseStamped, Vector3Stamped, WrenchStamped):
    it = message()
    it.header.frame_id, it.header.stamp = "base", rospy.Time(1, 250000000)
    print(shown(buffer.transform(it, "odom")))
    print(shown(buffer.transform(it, "map", rospy.Duration(0), message)))
    print(shown(buffer.transform_full(it, "odom", rospy.Time(2), "map")))
for message in (PolygonStamped, TwistStamped):
    try:
        buffer.transform(message(), "odom")
    except tf2_ros.TypeException as error:
        print("TypeException", message.__name__)
print(shown(tf2_geometry_msgs.to_msg_msg(Point(1, 2, 3))), shown(tf2_geometry_msgs.from_msg_msg(Point(1, 2, 3))))
for wrong in (5, PointStamped()):
    try:
        do_transform_pose(wrong, transform())
    except AttributeError as error:
        print(error)
"""
)

CLOUDS = (
    START
    + """
from tf2_sensor_msgs.tf2_sensor_msgs import do_transform_cloud
import tf2_sensor_msgs

for case in range(60):
    fields = [PointField(axis, 4 * place, 7, 1) for place, axis in enumerate("xyz")]
    layout = "<fff"
    others = (("ring", 4, "H", 1), ("intensity", 7, "f", 1), ("t", 8, "d", 1), ("n", 1, "b", 3))
    for name, kind, letter, count in others:
        if chance.random() < 0.5:
            fields.append(PointField(name, struct.calcsize(layout), kind, count))
            layout += "%d%s" % (count, letter)
    rest = chance.choice([0, 0, 5])
    width, height = chance.choice([(0, 1), (1, 1), (7, 1), (3, 2)])
    points = b""
    for _ in range(width * height):
        xyz = [chance.choice([0.0, chance.uniform(-99, 99), float("nan")]) for _ in range(3)]
        more = [chance.randrange(99) for field in fields[3:] for _ in range(field.count)]
        points += struct.pack(layout, *xyz, *more) + bytes(rest)
    step = struct.calcsize(layout) + rest
    cloud = PointCloud2(header("base"), height, width, fields, False, step, step * width, points, True)
    table(do_transform_cloud(cloud, transform()))
buffer = tf2_ros.Buffer(debug=False)
buffer.set_transform_static(TransformStamped(Header(0, rospy.Time(1), "map"), "base", transform().transform), "me")
cloud.header.frame_id = "base"
table(buffer.transform(cloud, "map"))
"""
)

SCANS = (
    START
    + """
from laser_geometry import LaserProjection
import laser_geometry.laser_geometry as module

print(LaserProjection.LASER_SCAN_INVALID, LaserProjection.LASER_SCAN_MIN_RANGE, LaserProjection.LASER_SCAN_MAX_RANGE)
options = LaserProjection.ChannelOption
print(options.NONE, options.INTENSITY, options.INDEX, options.DISTANCE, options.TIMESTAMP, options.VIEWPOINT)
print(options.DEFAULT)
projection = LaserProjection()
strange = [float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 0.5, 10.0]
for case in range(80):
    count = chance.choice([0, 1, 5, 30])
    ranges = [chance.choice([chance.uniform(0, 12), chance.choice(strange)]) for _ in range(count)]
    intensities = [float(number) for number in range(count)] if chance.random() < 0.7 else []
    start, step = chance.choice([(-1.0, 0.05), (0.0, 0.05), (-3.0, 0.2)])
    end = start + step * max(count - 1, 0)
    scan = LaserScan(header("laser"), start, end, step, 0.001, 0.1, 0.5, 10.0, ranges, intensities)
    table(projection.projectLaser(scan))
    cutoff, option = chance.choice([-1.0, 0.0, 5.0, 50.0]), chance.choice([0, 1, 2, 3, 4, 8, 16, 31, -1])
    table(projection.projectLaser(scan, cutoff, option))
    table(projection.projectLaser(scan_in=scan, range_cutoff=cutoff, channel_options=option))
try:
    projection.projectLaser(LaserScan(ranges=[1.0, 2.0], intensities=[1.0], range_max=9.0))
except IndexError:
    print("IndexError")
"""
)


def test_geometry(master: Master) -> None:
    said = same(master, GEOMETRY)
    assert said.count("PoseStamped{") == 403 and "TypeException TwistStamped" in said


def test_clouds(master: Master) -> None:
    assert "nan nan nan" in same(master, CLOUDS)


def test_scans(master: Master) -> None:
    assert "IndexError" in same(master, SCANS)
